/* The models of shell.c as FMI 1.0 FMUs for co-simulation, stand-alone. IDENTIFIER begins the names of
 * the functions. Strict where FMI 1.0 is: no values are given before fmiInitializeSlave, parameters
 * (variables below INPUTS_FROM) are set before it only. */
#include "shell.c"

#include "fmi1Functions.h"

#define JOIN(a, b) a##_##b
#define NAMED(a, b) JOIN(a, b)
#define FMI(name) NAMED(IDENTIFIER, name)
#define STATUS_OF(status) ((fmi1Status)(status))

const char *FMI(fmiGetTypesPlatform)(void) { return "standard32"; }
const char *FMI(fmiGetVersion)(void) { return "1.0"; }

fmi1Component FMI(fmiInstantiateSlave)(fmi1String name, fmi1String guid, fmi1String location,
                                       fmi1String type, fmi1Real timeout, fmi1Boolean visible,
                                       fmi1Boolean interactive, fmi1CallbackFunctions functions,
                                       fmi1Boolean logging) {
    if (strcmp(type, "application/x-fmu-sharedlibrary") || strncmp(location, "file://", 7)) return 0;
    fmi2CallbackFunctions callbacks = {.logger = (fmi2CallbackLogger)functions.logger};
    Model *m = fmi2Instantiate(name, fmi2CoSimulation, guid, location, &callbacks, 0, 0);
    if (m) m->environment = m;
    return m;
}
void FMI(fmiFreeSlaveInstance)(fmi1Component c) { fmi2FreeInstance(c); }
fmi1Status FMI(fmiInitializeSlave)(fmi1Component c, fmi1Real t0, fmi1Boolean stops, fmi1Real t1) {
    Model *m = c;
    if (m->running) {
        SAY(m, fmi2Error, "it is initialised already");
        return fmi1Error;
    }
    m->t = t0;
    m->running = m->initialised = 1;
    show(m);
    return fmi1OK;
}
fmi1Status FMI(fmiTerminateSlave)(fmi1Component c) { return (fmi1Status)fmi2Terminate(c); }
fmi1Status FMI(fmiResetSlave)(fmi1Component c) { return fmi1Error; }
fmi1Status FMI(fmiSetDebugLogging)(fmi1Component c, fmi1Boolean on) { return fmi1OK; }

fmi1Status FMI(fmiGetReal)(fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1Real v[]) {
    Model *m = c;
    if (!m->running) {
        SAY(m, fmi2Error, "no values before fmiInitializeSlave");
        return fmi1Error;
    }
    return STATUS_OF(fmi2GetReal(c, vr, n, v));
}
fmi1Status FMI(fmiSetReal)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1Real v[]) {
    Model *m = c;
    for (size_t i = 0; i < n && m->running; i++)
        if (vr[i] < INPUTS_FROM) {
            SAY(m, fmi2Error, "variable %d is set too late", (int)vr[i]);
            return fmi1Error;
        }
    return STATUS_OF(fmi2SetReal(c, vr, n, v));
}
fmi1Status FMI(fmiDoStep)(fmi1Component c, fmi1Real t, fmi1Real h, fmi1Boolean fresh) {
    Model *m = c;
    if (!m->running || fresh != fmi1True) return fmi1Error;
    return STATUS_OF(fmi2DoStep(c, t, h, 1));
}
fmi1Status FMI(fmiGetRealStatus)(fmi1Component c, const fmi1StatusKind k, fmi1Real *v) {
    return STATUS_OF(fmi2GetRealStatus(c, (fmi2StatusKind)k, v));
}
fmi1Status FMI(fmiSetRealInputDerivatives)(fmi1Component c, const fmi1ValueReference vr[], size_t n,
                                           const fmi1Integer o[], const fmi1Real v[]) {
    return STATUS_OF(fmi2SetRealInputDerivatives(c, vr, n, o, v));
}

#define NOTHING(name, ...) fmi1Status FMI(name)(__VA_ARGS__) { return fmi1Error; }
NOTHING(fmiGetInteger, fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1Integer v[])
NOTHING(fmiGetBoolean, fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1Boolean v[])
NOTHING(fmiGetString, fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1String v[])
NOTHING(fmiSetInteger, fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1Integer v[])
NOTHING(fmiSetBoolean, fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1Boolean v[])
NOTHING(fmiSetString, fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1String v[])
NOTHING(fmiGetRealOutputDerivatives, fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1Integer o[], fmi1Real v[])
NOTHING(fmiCancelStep, fmi1Component c)
NOTHING(fmiGetStatus, fmi1Component c, const fmi1StatusKind k, fmi1Status *v)
NOTHING(fmiGetIntegerStatus, fmi1Component c, const fmi1StatusKind k, fmi1Integer *v)
NOTHING(fmiGetBooleanStatus, fmi1Component c, const fmi1StatusKind k, fmi1Boolean *v)
NOTHING(fmiGetStringStatus, fmi1Component c, const fmi1StatusKind k, fmi1String *v)
