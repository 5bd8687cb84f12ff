#define FAST "v0"
