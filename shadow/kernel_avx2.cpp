#define RELUME_ISA avx2
#include "shadow/coverage_kernel_body.h"
