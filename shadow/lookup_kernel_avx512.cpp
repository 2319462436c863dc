#define RELUME_ISA avx512
#include "shadow/lookup_kernel_body.h"
