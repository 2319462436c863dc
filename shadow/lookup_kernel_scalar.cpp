#define RELUME_ISA scalar
#include "shadow/lookup_kernel_body.h"
