/* The C interface of FMI 2.0, as far as an FMU implements it. Names, values and arguments are those
   of the FMI Specification 2.0.4, sections 2.1, 3.2 and 4.2. */
#ifndef M4E_FMI2_H
#define M4E_FMI2_H

#include <stddef.h>

#ifdef _WIN32
#define FMI2(type) __declspec(dllexport) type
#else
#define FMI2(type) __attribute__((visibility("default"))) type
#endif

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Char, fmi2Byte;
typedef const fmi2Char *fmi2String;

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum {
    fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated
} fmi2StatusKind;

typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String name, fmi2Status, fmi2String category,
                   fmi2String message, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef struct {
    fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged,
        valuesOfContinuousStatesChanged, nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

/* both kinds */
FMI2(const char *) fmi2GetTypesPlatform(void);
FMI2(const char *) fmi2GetVersion(void);
FMI2(fmi2Status) fmi2SetDebugLogging(fmi2Component, fmi2Boolean on, size_t, const fmi2String[]);
FMI2(fmi2Component) fmi2Instantiate(fmi2String name, fmi2Type, fmi2String guid,
                                    fmi2String resources, const fmi2CallbackFunctions *,
                                    fmi2Boolean visible, fmi2Boolean logging);
FMI2(void) fmi2FreeInstance(fmi2Component);
FMI2(fmi2Status) fmi2SetupExperiment(fmi2Component, fmi2Boolean tolerant, fmi2Real tolerance,
                                     fmi2Real start, fmi2Boolean stops, fmi2Real stop);
FMI2(fmi2Status) fmi2EnterInitializationMode(fmi2Component);
FMI2(fmi2Status) fmi2ExitInitializationMode(fmi2Component);
FMI2(fmi2Status) fmi2Terminate(fmi2Component);
FMI2(fmi2Status) fmi2Reset(fmi2Component);

#define FMI2_GET(Type)                                                                            \
    FMI2(fmi2Status)                                                                              \
    fmi2Get##Type(fmi2Component, const fmi2ValueReference[], size_t, fmi2##Type[])
#define FMI2_SET(Type)                                                                            \
    FMI2(fmi2Status)                                                                              \
    fmi2Set##Type(fmi2Component, const fmi2ValueReference[], size_t, const fmi2##Type[])
FMI2_GET(Real);
FMI2_GET(Integer);
FMI2_GET(Boolean);
FMI2_GET(String);
FMI2_SET(Real);
FMI2_SET(Integer);
FMI2_SET(Boolean);
FMI2_SET(String);

FMI2(fmi2Status) fmi2GetFMUstate(fmi2Component, fmi2FMUstate *);
FMI2(fmi2Status) fmi2SetFMUstate(fmi2Component, fmi2FMUstate);
FMI2(fmi2Status) fmi2FreeFMUstate(fmi2Component, fmi2FMUstate *);
FMI2(fmi2Status) fmi2SerializedFMUstateSize(fmi2Component, fmi2FMUstate, size_t *);
FMI2(fmi2Status) fmi2SerializeFMUstate(fmi2Component, fmi2FMUstate, fmi2Byte[], size_t);
FMI2(fmi2Status) fmi2DeSerializeFMUstate(fmi2Component, const fmi2Byte[], size_t, fmi2FMUstate *);
FMI2(fmi2Status) fmi2GetDirectionalDerivative(fmi2Component, const fmi2ValueReference unknown[],
                                              size_t, const fmi2ValueReference known[], size_t,
                                              const fmi2Real seed[], fmi2Real result[]);

/* model exchange */
FMI2(fmi2Status) fmi2EnterEventMode(fmi2Component);
FMI2(fmi2Status) fmi2NewDiscreteStates(fmi2Component, fmi2EventInfo *);
FMI2(fmi2Status) fmi2EnterContinuousTimeMode(fmi2Component);
FMI2(fmi2Status) fmi2CompletedIntegratorStep(fmi2Component, fmi2Boolean no_return,
                                             fmi2Boolean *event, fmi2Boolean *terminate);
FMI2(fmi2Status) fmi2SetTime(fmi2Component, fmi2Real);
FMI2(fmi2Status) fmi2SetContinuousStates(fmi2Component, const fmi2Real[], size_t);
FMI2(fmi2Status) fmi2GetDerivatives(fmi2Component, fmi2Real[], size_t);
FMI2(fmi2Status) fmi2GetEventIndicators(fmi2Component, fmi2Real[], size_t);
FMI2(fmi2Status) fmi2GetContinuousStates(fmi2Component, fmi2Real[], size_t);
FMI2(fmi2Status) fmi2GetNominalsOfContinuousStates(fmi2Component, fmi2Real[], size_t);

/* co-simulation */
FMI2(fmi2Status) fmi2SetRealInputDerivatives(fmi2Component, const fmi2ValueReference[], size_t,
                                             const fmi2Integer order[], const fmi2Real[]);
FMI2(fmi2Status) fmi2GetRealOutputDerivatives(fmi2Component, const fmi2ValueReference[], size_t,
                                              const fmi2Integer order[], fmi2Real[]);
FMI2(fmi2Status) fmi2DoStep(fmi2Component, fmi2Real t, fmi2Real h, fmi2Boolean no_return);
FMI2(fmi2Status) fmi2CancelStep(fmi2Component);
FMI2(fmi2Status) fmi2GetStatus(fmi2Component, const fmi2StatusKind, fmi2Status *);
FMI2(fmi2Status) fmi2GetRealStatus(fmi2Component, const fmi2StatusKind, fmi2Real *);
FMI2(fmi2Status) fmi2GetIntegerStatus(fmi2Component, const fmi2StatusKind, fmi2Integer *);
FMI2(fmi2Status) fmi2GetBooleanStatus(fmi2Component, const fmi2StatusKind, fmi2Boolean *);
FMI2(fmi2Status) fmi2GetStringStatus(fmi2Component, const fmi2StatusKind, fmi2String *);

#endif
