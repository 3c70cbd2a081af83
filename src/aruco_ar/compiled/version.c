/* UNIT5_VERSION is given to the compiler; see compiler.py. */
#include "unit5.h"

const char *unit5_version(void) { return UNIT5_VERSION; }
