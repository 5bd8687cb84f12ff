#include <stdio.h>
#include <unistd.h>
const char * word(void);
int main(void) { printf("loop says %s\n", word()); fflush(stdout);
  for (;;) pause(); }
