// What the compute rasteriser draws into: pixels row by row, two words each, apart: the greatest nearness of all pixels,
// then their least ids.
#include "interface.h"

layout(std430, binding = BINDING_RASTER_PIXELS) buffer Pixels { uint pixels[]; };
