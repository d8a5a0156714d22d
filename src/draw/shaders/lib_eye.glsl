// Direction to the eye from a position in the picture; unit length in perspective.
#include "lib_item.glsl"
#include "lib_light.glsl"

vec3 to_eye(vec2 at)
{
    vec3 eye = view.eye_start.xyz + view.eye_across.xyz * at.x + view.eye_down.xyz * at.y;
    return view.parallel != 0u ? eye : unit(eye);
}
