// Pixels for blending splats in one pass.
#include "interface.h"

layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };
layout(std430, binding = BINDING_RASTER_PIXELS) coherent volatile buffer Pixels { tolerant_pixel pixels[]; };
