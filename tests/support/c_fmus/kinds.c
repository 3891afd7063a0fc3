/* An FMU of FMI 1.0, 2.0 or 3.0 (VERSION) with variables of all types; kinds.py describes it.
 *
 * n counts the periods that have passed at the end of a step. Of each type y = u + n: a Boolean is
 * negated by odd n, an enumeration goes round, a text gets n behind it (unless it is 0), elements of
 * arrays are u + n. y_real is the integral of u_real + u_int + u_bool. Outputs are as the last step
 * has left them, at the start 0 but for y_int, `offset`; THROUGH: as the inputs are now. CLEARS: setting anything clears them instead.
 * STATE saves states; EVENTS refuses discrete inputs outside of event mode.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if VERSION == 3
#include "fmi3Functions.h"
#elif VERSION == 2
#include "fmi2Functions.h"
#else
#include "fmi1Functions.h"
#endif

enum { OK, ERROR = 3, MOST = 64, ELEMENTS = 3, LENGTH = 256 };
enum { PERIOD, U_REAL, Y_REAL, U_INT, Y_INT, U_BOOL, Y_BOOL, U_ENUM, Y_ENUM, U_TEXT, Y_TEXT, OFFSET, TWICE,
       WIDTHS = 20, U_LIST = 40, Y_LIST, U_FLAGS, Y_FLAGS, U_FLOATS, Y_FLOATS, U_WORDS, Y_WORDS };

typedef struct {
    double real[MOST][ELEMENTS];
    long long whole[MOST][ELEMENTS];
    char text[MOST][ELEMENTS][LENGTH];
    long long n;
    int running, in_events;
} Model;

static void update(Model *m) {
    m->whole[Y_INT][0] = m->whole[U_INT][0] + m->whole[OFFSET][0] + m->n;
    m->whole[Y_BOOL][0] = m->whole[U_BOOL][0] ^ (m->n & 1);
    m->whole[Y_ENUM][0] = (m->whole[U_ENUM][0] - 1 + m->n) % 3 + 1;
    if (m->n) snprintf(m->text[Y_TEXT][0], LENGTH, "%.200s%lld", m->text[U_TEXT][0], m->n);
    else strcpy(m->text[Y_TEXT][0], m->text[U_TEXT][0]);
    for (int k = WIDTHS; k < U_LIST; k += 2) m->whole[k + 1][0] = m->whole[k][0] + m->n;
    for (int i = 0; i < ELEMENTS; i++) {
        m->whole[Y_LIST][i] = m->whole[U_LIST][i] + m->n;
        m->whole[Y_FLAGS][i] = m->whole[U_FLAGS][i] ^ (m->n & 1);
        m->real[Y_FLOATS][i] = m->real[U_FLOATS][i] + (double)m->n;
        strcpy(m->text[Y_WORDS][i], m->text[U_WORDS][i]);
    }
}

static void clear(Model *m) {
    for (int k = 0; k < MOST; k++)
        for (int i = 0; i < ELEMENTS; i++) {
            const int output = k == Y_INT || k == Y_BOOL || k == Y_TEXT || (k > WIDTHS && k % 2 && k < U_LIST);
            if (output) m->whole[k][i] = 0, m->text[k][i][0] = 0;
        }
}

static void is_set(Model *m) {
    m->whole[TWICE][0] = 2 * m->whole[OFFSET][0];
#ifdef THROUGH
    update(m);
#endif
#ifdef CLEARS
    if (m->running) clear(m);
#endif
}

static Model *made(void) {
    Model *m = calloc(1, sizeof *m);
    m->whole[U_ENUM][0] = m->whole[Y_ENUM][0] = 1;
    return m;
}

static int initialised(Model *m) {
    m->running = 1;
#ifdef THROUGH
    update(m);
#else
    m->whole[Y_INT][0] = m->whole[OFFSET][0];
#endif
    return OK;
}

static int stepped(Model *m, double t, double h) {
    const double rate = m->real[U_REAL][0] + (double)(m->whole[U_INT][0] + m->whole[U_BOOL][0]);
    m->real[Y_REAL][0] += h * rate;
    if (m->real[PERIOD][0] > 0) m->n = llround(floor((t + h) / m->real[PERIOD][0] + 1e-6));
    update(m);
    return OK;
}

static int get_text(Model *m, unsigned k, int i, const char **v) { *v = m->text[k][i]; return OK; }
static int set_text(Model *m, unsigned k, int i, const char *v) {
    if (strlen(v) >= LENGTH) return ERROR;
    strcpy(m->text[k][i], v);
    is_set(m);
    return OK;
}

#if VERSION == 3
static int elements(unsigned k) {
    if (k == U_FLAGS || k == Y_FLAGS || k == U_FLOATS || k == Y_FLOATS || k == U_WORDS || k == Y_WORDS) return 2;
    return k == U_LIST || k == Y_LIST ? 3 : 1;
}
static int refused(Model *m, unsigned k) {
#ifdef EVENTS
    return m->running == 2 && !m->in_events && k != U_REAL;
#endif
    return 0;
}
#define BOTH(name, type, get, set)                                                                                        \
    fmi3Status fmi3Get##name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, type v[], size_t nv) {              \
        Model *m = c; size_t at = 0; int status = OK;                                                                     \
        for (size_t j = 0; j < n; j++)                                                                                    \
            for (int i = 0; i < elements(vr[j]); i++, at++) { if (at == nv) return ERROR; get; }                          \
        return at == nv ? status : ERROR;                                                                                 \
    }                                                                                                                     \
    fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type v[], size_t nv) {        \
        Model *m = c; size_t at = 0; int status = OK;                                                                     \
        for (size_t j = 0; j < n; j++) {                                                                                  \
            if (refused(m, vr[j])) return ERROR;                                                                          \
            for (int i = 0; i < elements(vr[j]); i++, at++) { if (at == nv) return ERROR; set; }                          \
        }                                                                                                                 \
        is_set(m);                                                                                                        \
        return at == nv ? status : ERROR;                                                                                 \
    }
#define WHOLE(name, type) BOTH(name, type, v[at] = (type)m->whole[vr[j]][i], m->whole[vr[j]][i] = (long long)v[at])
WHOLE(Int8, fmi3Int8) WHOLE(UInt8, fmi3UInt8) WHOLE(Int16, fmi3Int16) WHOLE(UInt16, fmi3UInt16)
WHOLE(Int32, fmi3Int32) WHOLE(UInt32, fmi3UInt32) WHOLE(Int64, fmi3Int64) WHOLE(UInt64, fmi3UInt64)
WHOLE(Boolean, fmi3Boolean)
BOTH(Float64, fmi3Float64, v[at] = m->real[vr[j]][i], m->real[vr[j]][i] = v[at])
BOTH(Float32, fmi3Float32, v[at] = (float)m->real[vr[j]][i], m->real[vr[j]][i] = v[at])
BOTH(String, fmi3String, status |= get_text(m, vr[j], i, &v[at]), status |= set_text(m, vr[j], i, v[at]))

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[],
    size_t n_required, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) { return made(); }
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tolerance, fmi3Float64 t0, fmi3Boolean stops, fmi3Float64 t1) { return initialised(c); }
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { Model *m = c; m->in_events = 1; return initialised(c); }
fmi3Status fmi3Terminate(fmi3Instance c) { return OK; }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { Model *m = c; if (m->in_events) return ERROR; m->in_events = 1; return OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { Model *m = c; m->in_events = 0; m->running = 2; return OK; }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *a, fmi3Boolean *b, fmi3Boolean *n, fmi3Boolean *v, fmi3Boolean *d, fmi3Float64 *t) {
    *a = *b = *n = *v = *d = fmi3False;
    return OK;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    *event = *end = *early = fmi3False;
    *last = t + h;
    return stepped(c, t, h);
}
#ifdef STATE
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s) {
    if (!*s) *s = malloc(sizeof(Model));
    memcpy(*s, c, sizeof(Model));
    return OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s) { memcpy(c, s, sizeof(Model)); return OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) { free(*s); *s = NULL; return OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState s, size_t *n) { *n = sizeof(Model); return OK; }
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState s, fmi3Byte b[], size_t n) { memcpy(b, s, n); return OK; }
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte b[], size_t n, fmi3FMUState *s) {
    *s = memcpy(malloc(n), b, n);
    return OK;
}
#endif

#else /* ---- FMI 1.0 and 2.0 ---- */

#if VERSION == 2
#define F(name) fmi2##name
#define T(name) fmi2##name
#else
#define JOIN(a, b) a##_fmi##b
#define NAMED(a, b) JOIN(a, b)
#define F(name) NAMED(IDENTIFIER, name)
#define T(name) fmi1##name
#endif
#define READY(m) if (!(m)->running) return ERROR;
#define BOTH(name, get, set)                                                                               \
    T(Status) F(Get##name)(T(Component) c, const T(ValueReference) vr[], size_t n, T(name) v[]) {          \
        Model *m = c; int status = OK; const int i = 0; (void)i;                                           \
        READY(m)                                                                                           \
        for (size_t j = 0; j < n; j++) { get; }                                                            \
        return status;                                                                                     \
    }                                                                                                      \
    T(Status) F(Set##name)(T(Component) c, const T(ValueReference) vr[], size_t n, const T(name) v[]) {    \
        Model *m = c; int status = OK; const int i = 0; (void)i;                                           \
        for (size_t j = 0; j < n; j++) { set; }                                                            \
        is_set(m);                                                                                         \
        return status;                                                                                     \
    }
BOTH(Real, v[j] = m->real[vr[j]][0], m->real[vr[j]][0] = v[j])
BOTH(Integer, v[j] = (int)m->whole[vr[j]][0], m->whole[vr[j]][0] = v[j])
BOTH(Boolean, v[j] = (T(Boolean))m->whole[vr[j]][0], m->whole[vr[j]][0] = v[j])
BOTH(String, status |= get_text(m, vr[j], 0, &v[j]), status |= set_text(m, vr[j], 0, v[j]))
T(Status) F(DoStep)(T(Component) c, T(Real) t, T(Real) h, T(Boolean) fresh) { return stepped(c, t, h); }
#define NONE(name, ...) T(Status) F(name)(__VA_ARGS__) { return ERROR; }

#if VERSION == 2
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return fmi2OK; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) { return made(); }
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tol, fmi2Real t0, fmi2Boolean e, fmi2Real t1) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return initialised(c); }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return initialised(c); }
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
NONE(Reset, fmi2Component c)
NONE(GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference z[], size_t nz, const fmi2ValueReference v[], size_t nv, const fmi2Real dv[], fmi2Real dz[])
#ifdef STATE
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) {
    if (!*s) *s = malloc(sizeof(Model));
    memcpy(*s, c, sizeof(Model));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) { memcpy(c, s, sizeof(Model)); return fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { free(*s); *s = NULL; return fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { *n = sizeof(Model); return fmi2OK; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { memcpy(b, s, n); return fmi2OK; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) {
    *s = memcpy(malloc(n), b, n);
    return fmi2OK;
}
#else
NONE(SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
NONE(SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
NONE(DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NONE(GetFMUstate, fmi2Component c, fmi2FMUstate *s)
NONE(SetFMUstate, fmi2Component c, fmi2FMUstate s)
NONE(FreeFMUstate, fmi2Component c, fmi2FMUstate *s)
#endif
#else
const char *F(GetTypesPlatform)(void) { return "standard32"; }
const char *F(GetVersion)(void) { return "1.0"; }
fmi1Component F(InstantiateSlave)(fmi1String name, fmi1String guid, fmi1String location, fmi1String type,
                                  fmi1Real timeout, fmi1Boolean visible, fmi1Boolean interactive,
                                  fmi1CallbackFunctions functions, fmi1Boolean logging) { return made(); }
void F(FreeSlaveInstance)(fmi1Component c) { free(c); }
fmi1Status F(InitializeSlave)(fmi1Component c, fmi1Real t0, fmi1Boolean stops, fmi1Real t1) { return initialised(c); }
fmi1Status F(TerminateSlave)(fmi1Component c) { return fmi1OK; }
NONE(ResetSlave, fmi1Component c)
NONE(SetDebugLogging, fmi1Component c, fmi1Boolean on)
#endif
NONE(SetRealInputDerivatives, T(Component) c, const T(ValueReference) vr[], size_t n, const T(Integer) o[], const T(Real) v[])
NONE(GetRealOutputDerivatives, T(Component) c, const T(ValueReference) vr[], size_t n, const T(Integer) o[], T(Real) v[])
NONE(CancelStep, T(Component) c)
NONE(GetStatus, T(Component) c, const T(StatusKind) k, T(Status) *v)
NONE(GetRealStatus, T(Component) c, const T(StatusKind) k, T(Real) *v)
NONE(GetIntegerStatus, T(Component) c, const T(StatusKind) k, T(Integer) *v)
NONE(GetBooleanStatus, T(Component) c, const T(StatusKind) k, T(Boolean) *v)
NONE(GetStringStatus, T(Component) c, const T(StatusKind) k, T(String) *v)
#endif
