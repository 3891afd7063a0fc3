/* Layouts: which scalars a value reference stands for. */
#include <stdlib.h>
#include <string.h>

#include "instance.h"

int count_numbers(const char *text, size_t *lines, size_t *numbers) {
    int within = 0;
    *lines = *numbers = 0;
    for (; *text; ++text) {
        const int digit = *text >= '0' && *text <= '9';
        if (!digit && *text != ' ' && *text != '\n') return 0;
        *numbers += digit && !within;
        *lines += *text == '\n';
        within = digit;
    }
    return 1;
}

/* A scalar by its number in FMI, where calculated parameters follow the other parameters. */
static uint32_t scalar_of(const instance *c, uint32_t number) {
    const uint32_t before = c->n.parameters, after = before + c->n.calculated;
    if (number < before || number == scalars(c)) return number;
    return number < after ? first_calculated(c) + (number - before) : number - c->n.calculated;
}

/* The file has a line for each value reference, with the numbers of its scalars. */
static int fill(instance *c, const char *text) {
    layout *l = &c->layout;
    uint32_t line = 0, place = 0;
    l->start[0] = 0;
    while (*text) {
        if (*text >= '0' && *text <= '9') {
            const unsigned long number = strtoul(text, (char **)&text, 10);
            if (number > scalars(c)) return 0;
            l->scalar[place++] = scalar_of(c, (uint32_t)number);
        } else {
            if (*text == '\n') l->start[++line] = place;
            ++text;
        }
    }
    return l->start[line] == place;
}

/* The states in the order of the scalars; each must be there once. */
static int order_states(instance *c, size_t numbers) {
    layout *l = &c->layout;
    uint32_t found = 0;
    uint8_t *seen = calloc(c->n.states + (size_t)1, 1);
    for (size_t i = 0; seen && i < numbers; ++i) {
        const uint32_t s = l->scalar[i];
        if (s < first_state(c) || s >= first_output(c)) continue;
        const uint32_t state = s - first_state(c);
        if (seen[state]) break;
        seen[state] = 1;
        l->state[found++] = state;
    }
    free(seen);
    return found == c->n.states;
}

int read_layout(instance *c, const char *file) {
    layout *l = &c->layout;
    size_t size = 0, lines = scalars(c), numbers = lines;
    uint8_t *content = file ? read_resource(c, file, &size) : NULL;
    const char *text = (const char *)content;
    if (file && !text) return 0;
    int sound = !file || (count_numbers(text, &lines, &numbers) && lines < UINT32_MAX);
    if (sound) {
        l->variables = (uint32_t)lines;
        l->text = file ? l->variables : 0;
        l->start = malloc((lines + 1) * sizeof *l->start);
        l->scalar = malloc((numbers + 1) * sizeof *l->scalar);
        l->state = malloc((c->n.states + (size_t)1) * sizeof *l->state);
        sound = l->start && l->scalar && l->state;
    }
    for (uint32_t r = 0; sound && !file && r <= lines; ++r) {
        l->start[r] = r;
        l->scalar[r] = scalar_of(c, r);
    }
    if (sound && file) sound = fill(c, text);
    sound = sound && order_states(c, numbers);
    free(content);
    if (!sound) tell(c, FMI_ERROR, "%s is not of this FMU", file ? file : "the layout");
    return sound;
}

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
    const layout *l = &c->layout;
    size_t all = 0;
    if (count && !references) {
        tell(c, FMI_ERROR, "%s: no value references are given", c->function);
        return NULL;
    }
    for (size_t i = 0; i < count; ++i) {
        const uint32_t r = references[i];
        if (r >= l->variables) {
            tell(c, FMI_ERROR, "%s: there is no number with value reference %u", c->function, r);
            return NULL;
        }
        all += l->start[r + 1] - l->start[r];
    }
    if (all != numbers) {
        tell(c, FMI_ERROR, "%s: %zu values for %zu numbers", c->function, numbers, all);
        return NULL;
    }
    uint32_t *found = list_of(c, list, numbers);
    for (size_t i = 0, place = 0; found && i < count; ++i)
        for (uint32_t k = l->start[references[i]]; k < l->start[references[i] + 1]; ++k)
            found[place++] = l->scalar[k];
    return found;
}
