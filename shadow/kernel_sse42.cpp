#define RELUME_ISA sse42
#include "shadow/coverage_kernel_body.h"
