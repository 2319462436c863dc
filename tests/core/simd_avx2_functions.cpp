#define RELUME_ISA avx2
#include "tests/core/simd_functions_body.h"
