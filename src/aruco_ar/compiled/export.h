/* What the library shows. All else in it is hidden. */
#define EXPORT __attribute__((visibility("default")))
