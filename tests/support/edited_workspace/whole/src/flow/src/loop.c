#include <stdio.h>
#include <unistd.h>
#include <base/base.h>
#define string static const char *
#include <base/word_msg.h>
;
#include <fast.h>
const char * word(void);
int main(void) { (void)WORD; printf("loop says %s %s %s\n", "v0" , word(), FAST);
  fflush(stdout); for (;;) pause(); }
