#define BASE "v0"
