/* caller LIBRARY IMAGE WIDTH HEIGHT: calls a built library on any system, with a gray image in a file. Prints the
   library's version, a number that it exports, and the quadrilaterals in the image, x and y of their corners. */
#include <stdio.h>
#include <stdlib.h>
#include "image.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(library, name) ((void *)GetProcAddress(library, name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

enum { ROOM = 2000 };

int main(int count, char **words)
{
    static Point quads[ROOM][4];
    if (count != 5)
        return 2;
    void *library = OPEN(words[1]);
    if (!library)
        return 3;
    const char *(*version)(void) = FIND(library, "unit5_version");
    const int *levels = FIND(library, "unit5_levels");
    int64_t (*find_quads)(const Image *, int, float, int64_t, Point *) = FIND(library, "unit5_find_quads");
    int width = atoi(words[3]), height = atoi(words[4]);
    Image image = {malloc((size_t)width * height), width, width, height, 1};
    FILE *file = fopen(words[2], "rb");
    if (!file || fread(image.pixels, width, height, file) != (size_t)height)
        return 4;
    printf("%s\n%d\n", version(), *levels);
    int64_t found = find_quads(&image, 13, 80, ROOM, quads[0]);
    for (int64_t number = 0; number < found; number++)
        for (int corner = 0; corner < 4; corner++)
            printf("%.4f %.4f\n", quads[number][corner].x, quads[number][corner].y);
    return 0;
}
