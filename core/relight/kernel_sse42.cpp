#define RELUME_ISA sse42
#include "core/relight/kernel_body.h"
