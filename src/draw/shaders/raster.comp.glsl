// Draws splats without the graphics pipeline. Each thread sets up one splat and draws its pixels;
// all threads of a group together draw splats that cover many pixels. Nearness is at least 0, so
// its bits sort like the float.
#include "lib_pixels.glsl"
#include "lib_conic.glsl"
#include "lib_large.glsl"
#include "lib_fragment.glsl"

layout(local_size_x = RASTER_GROUP) in;

layout(std430, binding = BINDING_RASTER_COMMANDS) readonly buffer Commands { uvec4 commands[]; };
// First group of each command.
layout(std430, binding = BINDING_RASTER_GROUPS) readonly buffer Groups { uint first_groups[]; };

layout(std430, binding = BINDING_COUNTERS) buffer Counters { uint covered, layered, drawn_splats; };

layout(location = 0) uniform uint command_count;
layout(location = 1) uniform uint stage; // 0: nearness, 1: ids

shared uint group_command;
shared uint crowd_count;             // splats that all threads draw together
shared uint crowd[RASTER_GROUP];
shared uint drawn_count;             // splats of the group that are drawn

void store(ivec2 pixel, float nearness, uint id)
{
    uint width = uint(view.size.x), at = uint(pixel.y) * width + uint(pixel.x);
    uint bits = floatBitsToUint(nearness);
    if (stage == 0u) {
        // another thread may have written a nearer value by now: then nothing changes
        if (bits > pixels[at]) {
            atomicMax(pixels[at], bits);
        }
    } else if (bits == pixels[at]) {
        atomicMin(pixels[width * uint(view.size.y) + at], id);
    }
}

ivec4 clip_box(const splat_shape s)
{
    ivec4 box = ivec4(shape_box(s));
    return ivec4(max(box.xy, ivec2(0)), min(box.zw, ivec2(view.size.xy) - 1));
}

void draw_pixel(const splat_shape s, uvec3 hashed, ivec2 pixel)
{
    float nearness;
    if (has_pixel(s.center, s.conic, s.conic2, s.depths, s.clip, hashed, pixel, nearness)) {
        store(pixel, nearness, hashed.x);
    }
}

// The last command with first group <= `group`.
uint find_command(uint group)
{
    uint low = 0u, high = command_count;
    while (high - low > 1u) {
        uint middle = low + (high - low) / 2u;
        if (first_groups[middle] <= group) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// Draws one thread's splat. @return whether the whole group must draw it
bool draw_alone(uint number, const record_block record, const item_block item, uint local)
{
    splat_shape s;
    splat_place splat = place_splat(record, item, local);
    uint shape = shape_splat(record, item, splat, s);
    if (shape == SHAPE_NONE) {
        return false;
    }
    if (shape == SHAPE_LARGE) { // counted where it is drawn
        if (stage == 0u) {
            leave(number, local);
        }
        return false;
    }
    atomicAdd(drawn_count, 1u);
    uvec3 hashed = splat_hash(record, item, local, splat, splat.halvings, shape == SHAPE_PIXEL);
    if (shape == SHAPE_PIXEL) {
        draw_pixel(s, hashed, ivec2(floor(s.center.xy)));
        return false;
    }
    ivec4 box = clip_box(s);
    ivec2 size = box.zw - box.xy + 1;
    if (any(lessThan(size, ivec2(1)))) {
        return false;
    }
    if (size.x * size.y > RASTER_ALONE) {
        return true;
    }
    for (int y = box.y; y <= box.w; ++y) {
        for (int x = box.x; x <= box.z; ++x) {
            draw_pixel(s, hashed, ivec2(x, y));
        }
    }
    return false;
}

void draw_together(const record_block record, const item_block item, uint local)
{
    splat_shape s;
    splat_place splat = place_splat(record, item, local);
    shape_splat(record, item, splat, s);
    uvec3 hashed = splat_hash(record, item, local, splat, splat.halvings, false);
    ivec4 box = clip_box(s);
    ivec2 size = box.zw - box.xy + 1;
    for (int at = int(gl_LocalInvocationIndex); at < size.x * size.y; at += RASTER_GROUP) {
        draw_pixel(s, hashed, box.xy + ivec2(at % size.x, at / size.x));
    }
}

void main()
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (gl_LocalInvocationIndex == 0u) {
        group_command = find_command(group);
        crowd_count = 0u;
        drawn_count = 0u;
    }
    barrier();
    uvec4 command = commands[group_command];
    uint local = (group - first_groups[group_command]) * uint(RASTER_GROUP) + gl_LocalInvocationIndex;
    record_block record = records[command.w];
    item_block item = items[record.item];
    // groups beyond the last one draw nothing
    if (local < command.x && command.y > 0u && draw_alone(command.w, record, item, local)) {
        crowd[atomicAdd(crowd_count, 1u)] = local;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && stage == 0u && drawn_count > 0u) {
        atomicAdd(drawn_splats, drawn_count);
    }
    for (uint i = 0u; i < crowd_count; ++i) {
        draw_together(record, item, crowd[i]);
    }
}
