#define RELUME_ISA sse42
#include "tests/core/simd_functions_body.h"
