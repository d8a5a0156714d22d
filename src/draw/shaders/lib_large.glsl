// Queues splats for the large pass.
#include "interface.h"

layout(std430, binding = BINDING_LARGE) buffer Large {
    uint large_vertices, large_count, large_first, large_base;
    uvec2 large_places[];
};

void leave(uint record, uint local)
{
    uint at = atomicAdd(large_count, 1u);
    if (at < uint(LARGE_MAX)) {
        large_places[at] = uvec2(record, local);
    }
}
