#define RELUME_ISA scalar
#include "tests/core/simd_functions_body.h"
