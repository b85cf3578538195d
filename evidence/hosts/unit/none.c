/* The functions of both standards for what the units have none of: an error, whatever the arguments.
   They are apart from the standards' headers, whose parameters they leave unnamed. */
#include <stddef.h>
#define ERROR(name) int name() { return 3; }
#define NULL_POINTER(name) void *name() { return NULL; }

ERROR(fmi2GetInteger) ERROR(fmi2GetBoolean) ERROR(fmi2GetString)
ERROR(fmi2SetInteger) ERROR(fmi2SetBoolean) ERROR(fmi2SetString)
ERROR(fmi2GetDirectionalDerivative) ERROR(fmi2SetRealInputDerivatives) ERROR(fmi2GetRealOutputDerivatives)
ERROR(fmi2CancelStep) ERROR(fmi2GetStatus) ERROR(fmi2GetRealStatus) ERROR(fmi2GetIntegerStatus)
ERROR(fmi2GetBooleanStatus) ERROR(fmi2GetStringStatus)

NULL_POINTER(fmi3InstantiateModelExchange) NULL_POINTER(fmi3InstantiateScheduledExecution)
#define TYPE(name) ERROR(fmi3Get##name) ERROR(fmi3Set##name)
TYPE(Float32) TYPE(Int8) TYPE(UInt8) TYPE(Int16) TYPE(UInt16) TYPE(Int32) TYPE(UInt32) TYPE(Int64) TYPE(UInt64)
TYPE(Boolean) TYPE(String) TYPE(Binary) TYPE(Clock)
TYPE(IntervalDecimal) TYPE(IntervalFraction) TYPE(ShiftDecimal) TYPE(ShiftFraction) TYPE(ContinuousStates)
ERROR(fmi3GetNumberOfVariableDependencies) ERROR(fmi3GetVariableDependencies)
ERROR(fmi3GetDirectionalDerivative) ERROR(fmi3GetAdjointDerivative) ERROR(fmi3GetOutputDerivatives)
ERROR(fmi3EnterContinuousTimeMode) ERROR(fmi3CompletedIntegratorStep) ERROR(fmi3SetTime)
ERROR(fmi3GetContinuousStateDerivatives) ERROR(fmi3GetEventIndicators) ERROR(fmi3GetNominalsOfContinuousStates)
ERROR(fmi3GetNumberOfEventIndicators) ERROR(fmi3GetNumberOfContinuousStates) ERROR(fmi3ActivateModelPartition)
