#include <stdio.h>
#include <unistd.h>
#include <base/base.h>
#define string static const char *
#include <base/word_msg.h>
;

int main(void) { (void)WORD; printf("other says %s %s %s %s\n", "v0" , BUILT, BASE, WORD);
  fflush(stdout); for (;;) pause(); }
