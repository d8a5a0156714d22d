// What the compute rasteriser draws into: pixels row by row. WIDE: 64 bits each, turned nearness above id, the least
// wins. Else two words each, apart: the greatest nearness of all pixels, then their least ids.
#include "interface.h"

#ifdef WIDE
layout(std430, binding = BINDING_RASTER_PIXELS) buffer Pixels { uint64_t pixels[]; };
#else
layout(std430, binding = BINDING_RASTER_PIXELS) buffer Pixels { uint pixels[]; };
#endif
