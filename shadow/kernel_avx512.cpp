#define RELUME_ISA avx512
#include "shadow/coverage_kernel_body.h"
