#define RELUME_ISA avx2
#include "core/relight/kernel_body.h"
