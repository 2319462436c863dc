#define RELUME_ISA scalar
#include "shadow/coverage_kernel_body.h"
