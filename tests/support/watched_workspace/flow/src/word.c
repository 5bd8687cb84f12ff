const char * word(void) { return "one"; }
