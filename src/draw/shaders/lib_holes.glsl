// Holes of splats: which pixels are drawn.
#include "lib_item.glsl"
#include "lib_glass.glsl"

// `place`: relative to the pixel of the splat's centre
bool is_drawn(uvec3 hashed, ivec2 pixel, ivec2 place)
{
#ifdef GLASS
    if ((hashed.z & GLASS_HASHED) != 0u) {
        return float(hashed.z & 0xFFFFu) * (1.0 / 65535.0) > find_threshold(hashed.y, pixel, view.pattern);
    }
#endif
    return hashed.z >= 255u || has_fragment(hashed.z, hashed.y, place);
}
