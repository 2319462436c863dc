#define RELUME_ISA avx512
#include "core/relight/kernel_body.h"
