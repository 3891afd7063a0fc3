/* FMI 3.0: functions for what these FMUs have not. They answer an error with a text. */
#include "fmi3_calls.h"

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token,
                                               fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging_on,
                                               fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging_on;
    (void)update, (void)lock, (void)unlock;
    if (logger)
        logger(environment, fmi3Error, "logStatusError",
               "this FMU has no scheduled execution: it is one of co-simulation and model exchange");
    return NULL;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance self) {
    ENTER(INSTANTIATED | EVENT | STEP);
    NEEDS(0, "there are no structural parameters");
    return fmi3OK;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance self) {
    ENTER(0); /* it is never entered */
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance self) {
    ENTER(0); /* it is left for event mode only, which there is none of */
    return fmi3OK;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance self, fmi3ValueReference clock,
                                      fmi3Float64 time) {
    ENTER(0); /* there is no scheduled execution */
    (void)clock, (void)time;
    return fmi3OK;
}

/* Functions of variables that are not there: of other types, and clocks. */
#define NO_SUCH                                                                                   \
    ENTER(ANY | INTERMEDIATE);                                                                    \
    NEEDS(count == 0, "this FMU has no such variable");                                           \
    return fmi3OK
#define NONE_1(Name, A)                                                                           \
    fmi3Status fmi3##Name(fmi3Instance self, const fmi3ValueReference r[], size_t count, A a) {   \
        (void)r, (void)a;                                                                         \
        NO_SUCH;                                                                                  \
    }
#define NONE_2(Name, A, B)                                                                        \
    fmi3Status fmi3##Name(fmi3Instance self, const fmi3ValueReference r[], size_t count, A a,     \
                          B b) {                                                                  \
        (void)r, (void)a, (void)b;                                                                \
        NO_SUCH;                                                                                  \
    }
#define NONE_3(Name, A, B, C)                                                                     \
    fmi3Status fmi3##Name(fmi3Instance self, const fmi3ValueReference r[], size_t count, A a,     \
                          B b, C d) {                                                             \
        (void)r, (void)a, (void)b, (void)d;                                                       \
        NO_SUCH;                                                                                  \
    }
#define NO_NUMBER(Type)                                                                           \
    NONE_2(Get##Type, fmi3##Type *, size_t)                                                       \
    NONE_2(Set##Type, const fmi3##Type *, size_t)
NO_NUMBER(Float32)
NO_NUMBER(Int8)
NO_NUMBER(UInt8)
NO_NUMBER(Int16)
NO_NUMBER(UInt16)
NO_NUMBER(Int32)
NO_NUMBER(UInt32)
NO_NUMBER(Int64)
NO_NUMBER(UInt64)
NO_NUMBER(Boolean)
NONE_2(SetString, const fmi3String *, size_t)
NONE_3(GetBinary, size_t *, fmi3Binary *, size_t)
NONE_3(SetBinary, const size_t *, const fmi3Binary *, size_t)
NONE_1(GetClock, fmi3Clock *)
NONE_1(SetClock, const fmi3Clock *)
NONE_2(GetIntervalDecimal, fmi3Float64 *, fmi3IntervalQualifier *)
NONE_3(GetIntervalFraction, fmi3UInt64 *, fmi3UInt64 *, fmi3IntervalQualifier *)
NONE_1(GetShiftDecimal, fmi3Float64 *)
NONE_2(GetShiftFraction, fmi3UInt64 *, fmi3UInt64 *)
NONE_1(SetIntervalDecimal, const fmi3Float64 *)
NONE_2(SetIntervalFraction, const fmi3UInt64 *, const fmi3UInt64 *)
NONE_1(SetShiftDecimal, const fmi3Float64 *)
NONE_2(SetShiftFraction, const fmi3UInt64 *, const fmi3UInt64 *)
