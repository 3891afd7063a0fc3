/* The paths that URIs name, one line each: file_paths URI ... */
#include <stdio.h>

#include "instance.h"

int main(int count, char **words) {
    for (int i = 1; i < count; ++i) printf("%s\n", files_path(words[i], "f"));
    return 0;
}
