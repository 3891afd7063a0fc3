/* Dependencies of each element of a variable, as FMI 3.0 has them. */
#include <stdlib.h>

#include "instance.h"

struct dependencies {
    size_t count;
    dependency each[];
};

static int in_array(const instance *c, uint32_t reference, uint32_t element) {
    const layout *l = &c->layout;
    return reference < l->variables && element > 0 &&
           element <= l->start[reference + 1] - l->start[reference];
}

/* The file has a line of five numbers for each dependency, in the order of the variables. */
static int have_dependencies(instance *c) {
    static const char FILE_NAME[] = "dependencies.txt";
    enum { INDEPENDENT = 0, DEPENDENT = 5 };
    if (c->dependencies) return 1;
    size_t size = 0, lines = 0, numbers = 0;
    char *text = (char *)read_resource(c, FILE_NAME, &size), *next = text;
    if (!text) return 0;
    int sound = count_numbers(text, &lines, &numbers) && numbers == 5 * lines;
    struct dependencies *all =
        sound ? malloc(sizeof *all + (lines + 1) * sizeof *all->each) : NULL;
    sound = all != NULL;
    uint32_t before = 0;
    for (size_t i = 0; sound && i < lines; ++i) {
        uint32_t n[5];
        for (int k = 0; k < 5; ++k) n[k] = (uint32_t)strtoul(next, &next, 10);
        all->each[i] = (dependency){n[0], n[1], n[2], n[3], n[4]};
        sound = n[0] >= before && in_array(c, n[0], n[1]) && in_array(c, n[2], n[3]) &&
                n[4] > INDEPENDENT && n[4] <= DEPENDENT;
        before = n[0];
    }
    free(text);
    if (sound) {
        all->count = lines;
        c->dependencies = all;
        return 1;
    }
    free(all);
    tell(c, FMI_ERROR, "%s is not of this FMU", FILE_NAME);
    return 0;
}

/* First of the dependencies of a variable, and their number. */
static const dependency *find(const instance *c, uint32_t reference, size_t *count) {
    const struct dependencies *all = c->dependencies;
    size_t first = 0, end = 0;
    while (first < all->count && all->each[first].variable < reference) ++first;
    for (end = first; end < all->count && all->each[end].variable == reference;) ++end;
    *count = end - first;
    return all->each + first;
}

answer count_dependencies(instance *c, uint32_t reference, size_t *count) {
    CHECK(reference <= c->layout.text, "%s: there is no variable with value reference %u",
          c->function, reference);
    if (!have_dependencies(c)) return FMI_ERROR;
    find(c, reference, count);
    return FMI_OK;
}

const dependency *dependencies_of(instance *c, uint32_t reference, size_t count) {
    size_t there = 0;
    if (count_dependencies(c, reference, &there) != FMI_OK) return NULL;
    if (there == count) return find(c, reference, &there);
    tell(c, FMI_ERROR, "%s: %zu dependencies are asked for, but they are %zu", c->function, count,
         there);
    return NULL;
}
