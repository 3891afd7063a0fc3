/* References: which scalars value references stand for. */
#include <stdlib.h>

#include "instance.h"

/* A scalar by its number in FMI, where calculated parameters follow the other parameters. */
static uint32_t scalar_of(const instance *c, uint32_t number) {
    const uint32_t before = c->n.parameters, after = before + c->n.calculated;
    if (number < before) return number;
    return number < after ? first_calculated(c) + (number - before) : number - c->n.calculated;
}

uint32_t reference_count(const instance *c) { return scalars(c) + c->time_first; }

uint32_t text_reference(const instance *c) { return c->time_first ? reference_count(c) : 0; }

/* Room for a list, NULL and a message where there is none. */
static uint32_t *list_of(instance *c, int list, size_t numbers) {
    if (numbers < c->room[list]) return c->listed[list];
    const size_t room = 2 * numbers + 16;
    uint32_t *more = realloc(c->listed[list], room * sizeof *more);
    if (!more) {
        tell(c, FMI_ERROR, "%s: no memory for a list of variables", c->function);
        return NULL;
    }
    c->room[list] = room;
    return c->listed[list] = more;
}

const uint32_t *scalars_of(instance *c, const uint32_t references[], size_t count, size_t numbers,
                           int list) {
    if (count && !references) {
        tell(c, FMI_ERROR, "%s: no value references are given", c->function);
        return NULL;
    }
    if (count != numbers) {
        tell(c, FMI_ERROR, "%s: %zu values for %zu numbers", c->function, numbers, count);
        return NULL;
    }
    uint32_t *found = list_of(c, list, count);
    for (size_t i = 0; found && i < count; ++i) {
        const uint32_t r = references[i];
        if (r >= reference_count(c)) {
            tell(c, FMI_ERROR, "%s: there is no number with value reference %u", c->function, r);
            return NULL;
        }
        found[i] = c->time_first && r == 0 ? scalars(c) : scalar_of(c, r - c->time_first);
    }
    return found;
}
