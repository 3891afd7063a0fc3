/* Derivatives: of what is calculated by what is known, in a direction or adjoint to it, and by
   time. All come from the tangent, a program of its own (tangent.m4e). */
#include <math.h>
#include <string.h>

#include "instance.h"

static const size_t NOWHERE = SIZE_MAX;

/* Place in the tangent's inputs for a change of a scalar; NOWHERE where it cannot be a direction.
   Its inputs: ours, then changes of time, of states, of inputs, of parameters. */
static size_t direction_of(const instance *c, uint32_t s) {
    const size_t time = c->n.inputs, states = time + 1, inputs = states + c->n.states;
    if (s == scalars(c)) return time;
    if (s < first_input(c)) return inputs + c->n.inputs + s;
    if (s < first_state(c)) return inputs + (s - first_input(c));
    return s < first_output(c) ? states + (s - first_state(c)) : NOWHERE;
}

/* Change of a scalar that is calculated or a state, after `differentiate`. */
static double change_of(const instance *c, uint32_t s) {
    return s < first_output(c) ? c->direction[direction_of(c, s)] : c->changes[s - first_output(c)];
}

static int unknown_scalar(const instance *c, uint32_t s) {
    return s >= first_state(c) && s < scalars(c);
}

static int known_scalar(const instance *c, uint32_t s) { return direction_of(c, s) != NOWHERE; }

static void clear_direction(instance *c) {
    const size_t count = (size_t)c->n.inputs + 1 + c->n.states + c->n.parameters;
    memset(c->direction + c->n.inputs, 0, count * sizeof *c->direction);
}

/* Fills `changes` from `direction`: change of each output, then of each calculated parameter. */
static void differentiate(instance *c) {
    if (c->stale_tangent) m4e_set_parameters(c->tangent, c->p);
    c->stale_tangent = 0;
    if (c->n.inputs) memcpy(c->direction, c->u, c->n.inputs * sizeof *c->u);
    m4e_set_inputs(c->tangent, c->direction);
    m4e_outputs(c->tangent, c->now.t, c->x, c->changes);
}

/* As scalars_of; NULL and a message if one of them does not fit the role. */
static const uint32_t *in_role(instance *c, const uint32_t references[], size_t count,
                               size_t numbers, int (*fits)(const instance *, uint32_t),
                               const char *role, int list) {
    const uint32_t *s = scalars_of(c, references, count, numbers, list);
    for (size_t i = 0; s && i < numbers; ++i) {
        if (fits(c, s[i])) continue;
        tell(c, FMI_ERROR, "%s: %s is no %s", c->function, name_of(c, s[i]), role);
        return NULL;
    }
    return s;
}

/* The first change that is not finite is told. */
static answer changes_of(instance *c, const uint32_t s[], size_t count, double result[]) {
    answer how = FMI_OK;
    for (size_t i = 0; i < count; ++i) {
        result[i] = change_of(c, s[i]);
        if (!isfinite(result[i]) && how == FMI_OK)
            how = tell(c, FMI_DISCARD, "the derivative of %s is %g at t = %.9g s",
                       name_of(c, s[i]), result[i], c->now.t);
    }
    return how;
}

answer directional_derivative(instance *c, const uint32_t unknown[], size_t unknowns,
                              const uint32_t known[], size_t knowns, const double seed[],
                              size_t seeds, double result[], size_t results) {
    const uint32_t *y = in_role(c, unknown, unknowns, results, unknown_scalar, "unknown", 0);
    const uint32_t *x = y ? in_role(c, known, knowns, seeds, known_scalar, "known", 1) : NULL;
    if (!x) return FMI_ERROR;
    CHECK((seed || seeds == 0) && (result || results == 0),
          "%s: no seed or no room for the result is given", c->function);
    if (!have_tangent(c)) return FMI_ERROR;
    clear_direction(c);
    for (size_t i = 0; i < seeds; ++i) c->direction[direction_of(c, x[i])] += seed[i];
    differentiate(c);
    return changes_of(c, y, results, result);
}

/* The seeds go with the unknowns, the results with the knowns: a direction for each of these. */
answer adjoint_derivative(instance *c, const uint32_t unknown[], size_t unknowns,
                          const uint32_t known[], size_t knowns, const double seed[],
                          size_t seeds, double result[], size_t results) {
    const uint32_t *y = in_role(c, unknown, unknowns, seeds, unknown_scalar, "unknown", 0);
    const uint32_t *x = y ? in_role(c, known, knowns, results, known_scalar, "known", 1) : NULL;
    if (!x) return FMI_ERROR;
    CHECK((seed || seeds == 0) && (result || results == 0),
          "%s: no seed or no room for the result is given", c->function);
    if (!have_tangent(c)) return FMI_ERROR;
    answer how = FMI_OK;
    for (size_t i = 0; i < results; ++i) {
        clear_direction(c);
        c->direction[direction_of(c, x[i])] = 1.0;
        differentiate(c);
        result[i] = 0.0;
        for (size_t k = 0; k < seeds; ++k) result[i] += seed[k] * change_of(c, y[k]);
        if (!isfinite(result[i]) && how == FMI_OK)
            how = tell(c, FMI_DISCARD, "the derivative by %s is %g at t = %.9g s",
                       name_of(c, x[i]), result[i], c->now.t);
    }
    return how;
}

static int state_or_output(const instance *c, uint32_t s) {
    return s >= first_state(c) && s < first_calculated(c);
}

answer output_derivatives(instance *c, const uint32_t references[], size_t count,
                          const int32_t order[], double values[], size_t room) {
    const uint32_t *y = in_role(c, references, count, room, state_or_output, "output", 0);
    if (!y) return FMI_ERROR;
    CHECK((order && values) || count == 0, "%s: no orders are given", c->function);
    for (size_t i = 0; i < count; ++i)
        CHECK(order[i] == 1, "output derivatives are of order 1, not %d", (int)order[i]);
    CHECK(c->now.type == CO_SIMULATION, "%s: output derivatives belong to co-simulation",
          c->function);
    if (!have_tangent(c)) return FMI_ERROR;
    clear_direction(c);
    prepare(c);
    double *direction = c->direction + c->n.inputs;
    direction[0] = 1.0;
    m4e_rates(c->model, c->now.t, c->x, direction + 1);
    if (c->n.inputs)
        memcpy(direction + 1 + c->n.states, c->first, c->n.inputs * sizeof *c->first);
    differentiate(c);
    return changes_of(c, y, room, values);
}
