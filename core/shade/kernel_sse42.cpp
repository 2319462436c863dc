#define RELUME_ISA sse42
#include "core/shade/lobe_kernel_body.h"
