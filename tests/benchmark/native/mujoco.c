/* MuJoCo's forward dynamics behind plain C functions; constraints, contacts and sensors are off.
   The state x is q and u of each link in turn, angles absolute (systems.py). */
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    mjModel *model;
    mjData *data;
    int *turning; /* per link: the link it turns against, -1 the ground, -2 slides */
    int *place;   /* per link: its degree of freedom; MuJoCo numbers depth first */
    double *acceleration;
} peer;

static peer *selected;

void *mujoco_new(const char *path, const int *turning, const int *place, char *message, int room) {
    peer *p = calloc(1, sizeof *p);
    p->model = mj_loadXML(path, NULL, message, room);
    if (!p->model) {
        free(p);
        return NULL;
    }
    const size_t n = (size_t)p->model->nv;
    p->model->opt.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_EQUALITY | mjDSBL_FRICTIONLOSS |
                                  mjDSBL_LIMIT | mjDSBL_CONTACT | mjDSBL_WARMSTART |
                                  mjDSBL_ACTUATION | mjDSBL_SENSOR | mjDSBL_ISLAND |
                                  mjDSBL_AUTORESET;
    p->data = mj_makeData(p->model);
    p->turning = malloc(n * sizeof *p->turning);
    memcpy(p->turning, turning, n * sizeof *p->turning);
    p->place = malloc(n * sizeof *p->place);
    memcpy(p->place, place, n * sizeof *p->place);
    p->acceleration = malloc(n * sizeof *p->acceleration);
    return p;
}

int mujoco_size(void *self) { return (int)((peer *)self)->model->nv; }

void mujoco_set(void *self, const double *x) {
    peer *p = self;
    for (int k = 0; k < p->model->nv; k++) {
        const int against = p->turning[k];
        p->data->qpos[p->place[k]] = x[2 * k] - (against >= 0 ? x[2 * against] : 0.0);
        p->data->qvel[p->place[k]] = x[2 * k + 1] - (against >= 0 ? x[2 * against + 1] : 0.0);
    }
}

/* The accelerations at the state set last, in MuJoCo's own coordinates: what is timed. */
void mujoco_evaluate(void *self, double t, const double *x, double *rates) {
    (void)t, (void)x, (void)rates;
    mj_forward(((peer *)self)->model, ((peer *)self)->data);
}

void mujoco_rates(void *self, double t, const double *x, double *rates) {
    peer *p = self;
    mujoco_set(self, x);
    mujoco_evaluate(self, t, x, rates);
    for (int k = 0; k < p->model->nv; k++) {
        const int against = p->turning[k];
        p->acceleration[k] =
            p->data->qacc[p->place[k]] + (against >= 0 ? p->acceleration[against] : 0.0);
        rates[2 * k] = x[2 * k + 1];
        rates[2 * k + 1] = p->acceleration[k];
    }
}

void mujoco_select(void *self) { selected = self; }

/* The selected peer as the rates of an integrator that knows no `self`. */
void mujoco_kernel(const double *t, const double *x, const double *fixed, double *rates) {
    (void)fixed;
    mujoco_rates(selected, *t, x, rates);
}
