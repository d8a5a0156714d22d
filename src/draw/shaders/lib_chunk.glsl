// Locations of an item's splats.
#include "lib_item.glsl"

layout(std430, binding = BINDING_CHUNKS) readonly buffer Chunks { chunk_block chunks[]; };

// Chunk of a splat: the last one that begins at or before it.
chunk_block find_chunk(const item_block item, uint index)
{
    uint low = item.first_chunk, high = low + item.chunk_count;
    while (high - low > 1u) { // no load in the condition: llvmpipe would use chunks of other lanes
        uint middle = low + (high - low) / 2u;
        if (chunks[middle].begin <= index) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return chunks[low];
}

// Shading index of a splat.
uint find_shading(const item_block item, uint index)
{
    chunk_block chunk = find_chunk(item, index);
    uint local = index - chunk.begin, materials_at = chunk.address + 2u * (chunk.end - chunk.begin);
    return fetch(materials_at + local / 4u) >> (8u * (local & 3u)) & 255u;
}
