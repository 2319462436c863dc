#define RELUME_ISA avx512
#include "tests/core/simd_functions_body.h"
