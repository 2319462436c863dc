#define RELUME_ISA sse42
#include "shadow/lookup_kernel_body.h"
