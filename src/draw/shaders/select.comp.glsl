// One level of the walk down the graph, a node a thread: what is seen of it, by how many surfels, and what is below it for
// the next level. The rules are those of src/select (traverse.c, prefix.c, blend.c), for one eye, all of a scene, prefixes by
// insertion radius and one size of splats.
#include "interface.h"
#include "select_interface.h"
#include "lib_prefix.glsl"
#include "lib_sight.glsl"

layout(local_size_x = SELECT_GROUP) in;

layout(std430, binding = BINDING_SELECT_NODES) readonly buffer Nodes { select_node nodes[]; };
layout(std430, binding = BINDING_SELECT_EDGES) readonly buffer Edges { select_edge edges[]; };
layout(std430, binding = BINDING_SELECT_PARTS) readonly buffer Parts { select_part parts[]; };
layout(std430, binding = BINDING_SELECT_QUEUE) buffer Queue { select_entry queue[]; };
layout(std430, binding = BINDING_SELECT_LEVELS) buffer State { select_state state; };
layout(std430, binding = BINDING_SELECT_ITEMS) writeonly buffer Items { select_item items[]; };
layout(std430, binding = BINDING_SELECT_RUNS) writeonly buffer Runs { select_run runs[]; };
layout(std430, binding = BINDING_SELECT_COMMANDS) writeonly buffer Commands { uvec4 commands[]; };

layout(location = 0) uniform uint level;

#define GROW 1.1lf // STP_LEVELS_GROW
#define LACK 1.07lf
#define SHRINK (LACK * LACK * LACK * LACK)

struct set_use {
    uint count;
    double radius, switch_depth;
    bool extra;
};

double clamp_unit(double x)
{
    return x > 0.0lf ? (x < 1.0lf ? x : 1.0lf) : 0.0lf;
}

double growth(double ceiling, double depth)
{
    return depth <= ceiling ? 1.0lf : clamp_unit((GROW * ceiling - depth) / ((GROW - 1.0lf) * ceiling));
}

// stp_affine_scale
double scale_of(double m[12])
{
    double column = 0.0lf, sum = 0.0lf;
    for (int c = 0; c < 3; ++c) {
        double square = m[c] * m[c] + m[4 + c] * m[4 + c] + m[8 + c] * m[8 + c];
        column = max(column, square);
        sum += square;
    }
    bool uniform_scale = sum <= 3.0lf * column * (1.0lf + 1e-9lf) && sum >= 3.0lf * column * (1.0lf - 1e-9lf);
    return sqrt(uniform_scale ? column : sum);
}

double move_out(double lacks, box_sight sight)
{
    double along = clamp_unit(sight.far / sight.near - 2.0lf), cubed = lacks * lacks * lacks;
    return cubed * (1.0lf + along * (cubed * lacks - 1.0lf));
}

void use_count(uint set, uint count, double size, inout set_use use)
{
    use.count = count;
    double share = 0.5lf + 0.5lf * clamp_unit((4.0lf - size) / 2.0lf);
    use.radius = double(prefix_radius(set, count)) + share * double(sets[set].candidate_radius);
}

#define SPLAT_WORK 1.5lf      // STP_SPLAT_WORK
#define TRANSITION_WORK 1.2lf // STP_TRANSITION_WORK

// use_beside of src/select/prefix.c
void use_beside(uint set, uint count, double size, double below, double grown, inout set_use use)
{
    double own = SPLAT_WORK * double(count);
    double most = TRANSITION_WORK * max(own, below) - grown * below;
    if (most < own) {
        double part = double(count) * (most / own);
        count = part > 1.0lf ? uint(part) : 1u;
    }
    use_count(set, count, size, use);
}

// stp_select_use_set
set_use use_set(uint set, double reach, double below, bool cloud, double scale, box_sight sight)
{
    set_use use = set_use(0u, 0.0lf, SELECT_INFINITE, false);
    double per_depth = 0.5lf * view.splat_size / view.frame.scale / scale;
    if (sets[set].count == 0u || (sight.is_inside && !cloud)) {
        return use;
    }
    double from = reach / per_depth;
    uint count = prefix_count(set, float(per_depth * sight.near));
    double size = cloud ? 0.0lf : view.splat_size;
    if (cloud) {
        use_count(set, count, size, use);
        use.switch_depth = 0.0lf;
        return use;
    }
    if (sight.near >= from) {
        use.switch_depth = from;
        use_beside(set, count, size, below, growth(from, sight.near), use);
        return use;
    }
    use.switch_depth = from * move_out(from / sight.near, sight);
    use.extra = true;
    if (sight.far * SHRINK > use.switch_depth) {
        use_beside(set, count, size, below, 1.0lf, use);
    }
    return use;
}

// The depths between which splats from `index` on are drawn; 0 and infinite where none of what is seen lies beyond.
dvec2 depths_of(const set_use use, double ceiling, box_sight sight, uint index)
{
    dvec2 range = dvec2(0.0lf, SELECT_INFINITE);
    double along = double(index) / double(use.count);
    if (use.extra) {
        double gone = 1.0lf / SHRINK;
        range.x = use.switch_depth * (gone + along * (1.0lf - gone));
    }
    if (ceiling < SELECT_INFINITE) {
        range.y = ceiling * (GROW - along * (GROW - 1.0lf));
    }
    range.x = range.x <= sight.near ? 0.0lf : range.x;
    range.y = range.y >= sight.far ? SELECT_INFINITE : range.y;
    return range;
}

uint run_end(uint begin, uint prefix)
{
    uint size = max(begin / 8u / 64u * 64u, 64u);
    return prefix - begin - 1u < size ? prefix : begin + size;
}

// Runs that begin at or after `begin`, where those before are one.
uint count_runs(uint begin, uint prefix)
{
    uint count = 0u;
    while (begin < prefix) {
        begin = run_end(begin, prefix);
        count += 1u;
    }
    return count;
}

void command_splats(uint item, uint count)
{
    uint at = atomicAdd(state.splat_commands, 1u);
    if (at < uint(SELECT_COMMANDS)) {
        commands[at] = uvec4(count, 1u, 0u, item);
    }
}

// As many runs as differ; what is drawn wherever it is seen is one before them.
void add_runs(const set_use use, double ceiling, box_sight sight, uint number, inout select_item item)
{
    uint whole = 0u; // splats before are drawn wherever they are seen
    while (whole < item.prefix) {
        dvec2 range = depths_of(use, ceiling, sight, whole);
        if (range.x > 0.0lf || range.y < SELECT_INFINITE) {
            break;
        }
        whole = run_end(whole, item.prefix);
    }
    if (whole >= item.prefix) {
        return;
    }
    item.run_count = count_runs(whole, item.prefix) + (whole > 0u ? 1u : 0u);
    item.first_run = atomicAdd(state.runs, item.run_count);
    if (item.first_run + item.run_count > uint(SELECT_RUNS)) {
        state.overflow = 1u;
        return;
    }
    uint at = item.first_run;
    if (whole > 0u) {
        runs[at++] = select_run(whole, 0.0, uintBitsToFloat(0x7F800000u), number);
        command_splats(number, whole);
    }
    for (uint begin = whole; begin < item.prefix;) {
        uint end = run_end(begin, item.prefix);
        dvec2 range = depths_of(use, ceiling, sight, begin);
        float farthest = range.y < 3.4e38lf ? float(range.y * (1.0lf + 1e-6lf)) : uintBitsToFloat(0x7F800000u);
        runs[at++] = select_run(end, float(range.x * (1.0lf - 1e-6lf)), farthest, number);
        command_splats(number, end - begin);
        begin = end;
    }
}

bool take_item(out uint number)
{
    number = atomicAdd(state.items, 1u);
    if (number >= uint(SELECT_ITEMS)) {
        state.overflow = 1u;
    }
    return number < uint(SELECT_ITEMS);
}

// stp_select_add_set
void add_set(uint set, const select_entry at, const set_use use, box_sight sight)
{
    double share = growth(at.ceiling, sight.near);
    if (use.extra) {
        double gone = 1.0lf / SHRINK;
        share *= clamp_unit((sight.far / use.switch_depth - gone) / (1.0lf - gone));
    }
    select_item item = select_item(at.m, KIND_SURFELS, set, uint(share * double(use.count)), use.count, 0u, 0u,
                                   float(use.radius), 0.0, 0.0);
    uint number;
    if (item.prefix == 0u || !take_item(number)) {
        return;
    }
    bool flat_set = sight.far < sight.near * 1.02lf;
    if (!flat_set && (use.extra || sight.far > at.ceiling)) {
        add_runs(use, at.ceiling, sight, number, item);
    }
    if (item.run_count == 0u) {
        command_splats(number, item.prefix);
    }
    items[number] = item;
}

void add_part(const select_part part, const select_entry at)
{
    box_place box = box_place(dvec3(part.box[0], part.box[1], part.box[2]), dvec3(part.box[3], part.box[4], part.box[5]));
    box_sight sight;
    uint number;
    if (part.count == 0u || !see(place_box(at.m, box), sight) || !(growth(at.ceiling, sight.near) > 0.0lf) ||
        (part.kind == KIND_POINTS && sight.near > at.ceiling) || !take_item(number)) {
        return;
    }
    bool mesh = part.kind == KIND_MESH;
    select_item item = select_item(at.m, part.kind, part.index, mesh ? 0u : part.count, mesh ? 0u : part.count, 0u, 0u,
                                   0.0, 0.0, 0.0);
    if (mesh && sight.far > at.ceiling) {
        item.fade_begin = float(at.ceiling);
        item.fade_end = float(at.ceiling * GROW);
    }
    items[number] = item;
    if (!mesh) {
        command_splats(number, part.count);
        return;
    }
    uint command = atomicAdd(state.triangle_commands, 1u);
    if (command < uint(SELECT_COMMANDS)) {
        commands[uint(SELECT_COMMANDS) + command] = uvec4(3u * part.count, 1u, 0u, number);
    }
}

void push(const select_entry at, const select_edge edge)
{
    uint next = level + 1u, place = atomicAdd(state.levels[4u * next + 3u], 1u);
    if (place >= uint(SELECT_QUEUE)) {
        state.overflow = 1u;
        return;
    }
    atomicMax(state.levels[4u * next], place / uint(SELECT_GROUP) + 1u);
    select_entry below = at;
    below.node = edge.node;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
            below.m[4 * r + c] = at.m[4 * r] * edge.m[c] + at.m[4 * r + 1] * edge.m[4 + c] +
                                 at.m[4 * r + 2] * edge.m[8 + c] + (c == 3 ? at.m[4 * r + 3] : 0.0lf);
        }
    }
    queue[(next & 1u) * uint(SELECT_QUEUE) + place] = below;
}

void open_node(const select_node node, const select_entry at)
{
    bool moving_only = (at.flags & SELECT_MOVING_ONLY) != 0u;
    for (uint i = 0u; i < node.part_count && !moving_only; ++i) {
        add_part(parts[node.first_part + i], at);
    }
    for (uint i = 0u; i < node.edge_count; ++i) {
        select_edge edge = edges[node.first_edge + i];
        if (!moving_only || (nodes[edge.node].flags & (SELECT_MOVES | SELECT_MOVES_BELOW)) != 0u) {
            push(at, edge);
        }
    }
}

bool hide(const select_node node, const select_entry at, box_place box, double scale)
{
    double reach = double(node.margin) * scale * (1.0lf + 1e-6lf);
    bool hidden = view.pyramid_levels > 0u &&
                  is_hidden(box_place(box.low - reach, box.high + reach), 0.5lf * LACK * view.splat_size);
    if (hidden) {
        atomicAdd(state.hidden, 1u);
    }
    return hidden;
}

void visit(select_entry at)
{
    select_node node = nodes[at.node];
    bool moving_only = (at.flags & SELECT_MOVING_ONLY) != 0u, below = (node.flags & SELECT_MOVES_BELOW) != 0u;
    if ((node.flags & SELECT_MOVES) != 0u) { // no ancestor shows it
        moving_only = false;
        at.ceiling = SELECT_INFINITE;
    }
    box_place box = place_box(at.m, box_place(dvec3(node.box[0], node.box[1], node.box[2]),
                                              dvec3(node.box[3], node.box[4], node.box[5])));
    box_sight sight;
    atomicAdd(state.visited, 1u);
    if (!(node.box[0] <= node.box[3]) || !see(box, sight)) {
        return;
    }
    double scale = scale_of(at.m);
    moving_only = moving_only || !(growth(at.ceiling, sight.near) > 0.0lf);
    if ((moving_only && !below) || hide(node, at, box, scale)) {
        return;
    }
    if (!moving_only && node.set != NO_ID) {
        set_use use = use_set(node.set, node.reach * min(double(node.spare), view.spare), double(node.work), (node.flags & SELECT_CLOUD) != 0u, scale, sight);
        if (use.count > 0u) {
            add_set(node.set, at, use, sight);
        }
        at.ceiling = min(at.ceiling, use.switch_depth);
        moving_only = !(growth(at.ceiling, sight.near) > 0.0lf);
    }
    if (!moving_only || below) {
        at.flags = moving_only ? SELECT_MOVING_ONLY : 0u;
        open_node(node, at);
    }
}

void main()
{
    uint count = min(state.levels[4u * level + 3u], uint(SELECT_QUEUE));
    if (gl_GlobalInvocationID.x < count) {
        visit(queue[(level & 1u) * uint(SELECT_QUEUE) + gl_GlobalInvocationID.x]);
    }
}
