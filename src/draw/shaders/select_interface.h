// SPDX-License-Identifier: MIT
// What selection by a compute shader reads and writes (all std430). Numbers are doubles, as the processor's: lists differ
// where a sum is rounded otherwise, and nowhere else.

#define BINDING_SELECT_NODES 0
#define BINDING_SELECT_EDGES 1
#define BINDING_SELECT_PARTS 2
#define BINDING_SELECT_SETS 3
#define BINDING_SELECT_QUEUE 4  // entries of even levels, then of odd ones
#define BINDING_SELECT_LEVELS 5 // select_state
#define BINDING_SELECT_ITEMS 6
#define BINDING_SELECT_RUNS 7
#define BINDING_SELECT_COMMANDS 8 // of splats, then of triangles
#define BINDING_SELECT_VIEW 9
#define BINDING_SELECT_PYRAMID 10

#define SELECT_GROUP 64
#define SELECT_LEVELS 64   // of a graph
#define SELECT_QUEUE 65536 // entries of a level
#define SELECT_ITEMS 65536
#define SELECT_RUNS 1048576
#define SELECT_COMMANDS 1048576 // of a kind
#define SELECT_TABLE 64
#define SELECT_PYRAMID_LEVELS 16
#define SELECT_INFINITE 1e300

// Flags of nodes, the first two as stp_select_graph.
#define SELECT_MOVES 1u
#define SELECT_MOVES_BELOW 2u
#define SELECT_CLOUD 4u

// Flags of entries.
#define SELECT_MOVING_ONLY 1u

struct select_node {
    double box[6]; // low, high
    double reach;  // as in stp_select_graph
    uint first_edge, edge_count, first_part, part_count;
    uint set, flags;
    float margin;
    float spare;
    float work; // of what is drawn instead of the set, at most
    uint select_node_spare;
};

struct select_edge {
    double m[12];
    uint node, spare;
};

struct select_part {
    float box[6];
    uint kind, index, count, spare; // stp_draw_kind; triangles or points
};

struct select_set {
    uint count, table_size;
    float candidate_radius;
    uint spare;
    uint counts[SELECT_TABLE];
    float radii[SELECT_TABLE];
};

struct select_entry {
    double m[12];
    double ceiling;
    uint node, flags;
};

struct select_item {
    double m[12];
    uint kind, index, prefix, full_prefix;
    uint first_run, run_count;
    float radius, fade_begin, fade_end;
};

struct select_run {
    uint end;
    float nearest, farthest;
    uint item;
};

// Counters, and the commands that look at each level.
struct select_state {
    uint items, runs, splat_commands, triangle_commands;
    uint hidden, visited, overflow, spare;
    uint levels[4 * SELECT_LEVELS]; // groups, 1, 1, entries
};

struct select_frame {
    double eye[3], right[3], down[3], forward[3];
    double scale, center_x, center_y, near_distance, width, height, corner;
    double sides[12], side_limits[4];
};

#ifdef __STDC_VERSION__
typedef struct select_frame select_frame;
#endif

struct select_view {
    select_frame frame;
    select_frame pyramid_frame;
    double splat_size;
    double spare;
    uint parallel, pyramid_levels; // 0: nothing is hidden
    uint columns[SELECT_PYRAMID_LEVELS], rows[SELECT_PYRAMID_LEVELS],
        offsets[SELECT_PYRAMID_LEVELS];
};
