#include <stdio.h>
#include <unistd.h>

int main(void) { printf("other says %s\n", "one"); fflush(stdout);
  for (;;) pause(); }
