// What the compute rasteriser has drawn, into the visibility buffer. Of 64-bit pixels the low word is the id.
#include "interface.h"

layout(std430, binding = BINDING_RASTER_PIXELS) readonly buffer Pixels { uint pixels[]; };
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };

layout(location = 0) out uint id;

void main()
{
    uint width = uint(view.size.x), at = uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x);
#ifdef WIDE
    id = pixels[2u * at];
    float nearness = uintBitsToFloat(~pixels[2u * at + 1u]);
#else
    id = pixels[width * uint(view.size.y) + at];
    float nearness = uintBitsToFloat(pixels[at]);
#endif
    if (id == NO_ID) {
        discard;
    }
    gl_FragDepth = nearness;
}
