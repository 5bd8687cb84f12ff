const char * word(void) { return "v0"; }
