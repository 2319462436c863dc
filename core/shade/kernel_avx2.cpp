#define RELUME_ISA avx2
#include "core/shade/lobe_kernel_body.h"
