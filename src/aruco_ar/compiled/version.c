/* Which sources the library was made of: UNIT5_VERSION is given to the compiler. See library.py. */
#include "export.h"

EXPORT const char *unit5_version(void) { return UNIT5_VERSION; }
