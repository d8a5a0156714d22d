// Copies the compute rasteriser's output into the visibility buffer.
#include "interface.h"

layout(std430, binding = BINDING_RASTER_PIXELS) readonly buffer Pixels { uint pixels[]; };
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };

layout(location = 0) out uint id;

void main()
{
    uint width = uint(view.size.x), at = uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x);
    id = pixels[width * uint(view.size.y) + at];
    float nearness = uintBitsToFloat(pixels[at]);
    if (id == NO_ID) {
        discard;
    }
    gl_FragDepth = nearness;
}
