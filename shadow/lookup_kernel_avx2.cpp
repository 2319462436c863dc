#define RELUME_ISA avx2
#include "shadow/lookup_kernel_body.h"
