// Buffer of the compute rasteriser, row by row, in two planes: first the maximum nearness of all
// pixels, then their minimum ids.
#include "interface.h"

layout(std430, binding = BINDING_RASTER_PIXELS) buffer Pixels { uint pixels[]; };
