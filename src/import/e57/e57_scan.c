// SPDX-License-Identifier: MIT
#include "import/e57/e57.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define UNBOUNDED 1e30 ///< writers use the largest float for a value without limits

typedef struct slot_name {
    const char* name;
    stp_e57_slot slot;
} slot_name;

static const slot_name cartesian_names[] = {{"cartesianX", STP_E57_X},
                                            {"cartesianY", STP_E57_Y},
                                            {"cartesianZ", STP_E57_Z},
                                            {"cartesianInvalidState", STP_E57_INVALID}};
static const slot_name spherical_names[] = {{"sphericalRange", STP_E57_X},
                                            {"sphericalAzimuth", STP_E57_Y},
                                            {"sphericalElevation", STP_E57_Z},
                                            {"sphericalInvalidState", STP_E57_INVALID}};
static const slot_name other_names[] = {
    {"intensity", STP_E57_INTENSITY}, {"isIntensityInvalid", STP_E57_INTENSITY_INVALID},
    {"colorRed", STP_E57_RED},        {"colorGreen", STP_E57_GREEN},
    {"colorBlue", STP_E57_BLUE},      {"isColorInvalid", STP_E57_COLOR_INVALID},
    {"rowIndex", STP_E57_ROW},        {"columnIndex", STP_E57_COLUMN},
    {"nor:normalX", STP_E57_NX},      {"nor:normalY", STP_E57_NY},
    {"nor:normalZ", STP_E57_NZ},      {"returnIndex", STP_E57_RETURN},
    {"returnCount", STP_E57_RETURNS}, {"timeStamp", STP_E57_TIME}};

static stp_e57_slot find_name(const char* name, const slot_name* names, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (strcmp(names[i].name, name) == 0) {
            return names[i].slot;
        }
    }
    return STP_E57_SLOTS;
}

static stp_e57_slot find_slot(const stp_e57_scan* scan, const char* name)
{
    stp_e57_slot slot = find_name(name, scan->spherical ? spherical_names : cartesian_names, 4);
    return slot != STP_E57_SLOTS
               ? slot
               : find_name(name, other_names, sizeof(other_names) / sizeof(other_names[0]));
}

bool stp_e57_keeps(const char* name, bool spherical)
{
    const stp_e57_scan scan = {.spherical = spherical};
    return find_slot(&scan, name) != STP_E57_SLOTS;
}

// The number in an element; an empty one is zero. @return false if it is missing or not a number
static bool read_element(const stp_e57_node* node, double* value)
{
    if (node != NULL && node->text.length == 0) {
        *value = 0.0;
        return true;
    }
    return node != NULL && stp_e57_number(&node->text, value);
}

static unsigned count_bits(uint64_t span)
{
    unsigned bits = 0;
    while (bits < 64 && span >> bits != 0) {
        bits += 1;
    }
    assert(bits == 64 || span >> bits == 0);
    return bits;
}

static bool is_type(const stp_e57_node* node, const char* type)
{
    const stp_e57_text* text = stp_e57_attribute_of(node, "type");
    size_t length = strlen(type);
    return text != NULL && text->length == length && memcmp(text->bytes, type, length) == 0;
}

// Reads the encoding of one element of the prototype. @return false if it is invalid
static bool read_field(const stp_e57_node* node, stp_e57_field* f)
{
    *f = (stp_e57_field){.used = true, .scale = 1.0, .low = 1.0};
    const stp_e57_text* minimum = stp_e57_attribute_of(node, "minimum");
    const stp_e57_text* maximum = stp_e57_attribute_of(node, "maximum");
    if (is_type(node, "Float")) {
        const stp_e57_text* precision = stp_e57_attribute_of(node, "precision");
        bool single = precision != NULL && precision->length == 6 &&
                      memcmp(precision->bytes, "single", 6) == 0;
        double low, high;
        f->is_float = true;
        f->bits = single ? 32 : 64;
        bool bounded = stp_e57_number(minimum, &low) && stp_e57_number(maximum, &high);
        if (bounded && low > -UNBOUNDED && high < UNBOUNDED) {
            f->low = low;
            f->high = high;
        }
        return true;
    }
    if (!is_type(node, "Integer") && !is_type(node, "ScaledInteger")) {
        return false;
    }
    int64_t low = INT64_MIN, high = INT64_MAX;
    bool bounded = stp_e57_integer(minimum, &low);
    bounded = stp_e57_integer(maximum, &high) && bounded;
    if (is_type(node, "ScaledInteger")) {
        (void)stp_e57_number(stp_e57_attribute_of(node, "scale"), &f->scale);
        (void)stp_e57_number(stp_e57_attribute_of(node, "offset"), &f->offset);
    }
    f->minimum = low;
    f->bits = count_bits((uint64_t)high - (uint64_t)low);
    if (bounded) {
        f->low = (double)low * f->scale + f->offset;
        f->high = (double)high * f->scale + f->offset;
    }
    return low <= high && isfinite(f->scale) && isfinite(f->offset);
}

// Numbers the streams in the order of the prototype's elements.
static bool read_prototype(const stp_e57_node* node, stp_e57_scan* scan)
{
    for (const stp_e57_node* child = node->first; child != NULL; child = child->next) {
        if (is_type(child, "Structure")) {
            if (!read_prototype(child, scan)) {
                return false;
            }
            continue;
        }
        stp_e57_slot slot = find_slot(scan, child->name);
        bool wanted = slot < STP_E57_SLOTS && !scan->fields[slot].used;
        if (wanted && !read_field(child, &scan->fields[slot])) {
            return false;
        }
        if (wanted) {
            scan->fields[slot].stream = scan->stream_count;
        }
        scan->unused += !wanted;
        scan->stream_count += 1;
    }
    return true;
}

// A rotation as a quaternion, then a translation.
static bool read_pose(const stp_e57_node* node, stp_affine* pose)
{
    static const char* const turn_names[] = {"w", "x", "y", "z"};
    const stp_e57_node* turn = stp_e57_child(node, "rotation");
    const stp_e57_node* shift = stp_e57_child(node, "translation");
    double q[4] = {1.0, 0.0, 0.0, 0.0}, t[3] = {0};
    *pose = stp_affine_identity();
    for (int i = 0; i < 4; ++i) {
        (void)read_element(stp_e57_child(turn, turn_names[i]), &q[i]);
    }
    for (int i = 0; i < 3; ++i) {
        (void)read_element(stp_e57_child(shift, turn_names[i + 1]), &t[i]);
        pose->m[i][3] = t[i];
    }
    double size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(size > 1e-12 && size < 1e12) || !(fabs(t[0]) + fabs(t[1]) + fabs(t[2]) < 1e15)) {
        return false;
    }
    assert(isfinite(size) && isfinite(t[0]) && isfinite(t[1]) && isfinite(t[2]));
    double s = 2.0 / size, w = q[0], x = q[1], y = q[2], z = q[3];
    const double m[3][3] = {{1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
                            {s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)},
                            {s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i) {
        memcpy(pose->m[i], m[i], sizeof(m[i]));
    }
    return true;
}

// The scan's range of a value overrides that of its encoding.
static void read_limits(const stp_e57_node* node, const char* list, const char* low,
                        const char* high, stp_e57_field* f)
{
    const stp_e57_node* limits = stp_e57_child(node, list);
    double low_value, high_value;
    if (read_element(stp_e57_child(limits, low), &low_value) &&
        read_element(stp_e57_child(limits, high), &high_value) && low_value < high_value) {
        f->low = low_value;
        f->high = high_value;
    }
}

static void find_grid(stp_e57_scan* scan)
{
    const stp_e57_field *row = &scan->fields[STP_E57_ROW], *column = &scan->fields[STP_E57_COLUMN];
    bool whole =
        row->scale == 1.0 && row->offset == 0.0 && column->scale == 1.0 && column->offset == 0.0;
    if (!whole || !row->used || !column->used || row->is_float || column->is_float ||
        row->bits > 31 || column->bits > 31 || row->low > row->high || column->low > column->high) {
        return;
    }
    uint64_t rows = (uint64_t)(row->high - row->low) + 1;
    uint64_t columns = (uint64_t)(column->high - column->low) + 1;
    assert(rows > 0 && columns > 0 && rows <= UINT64_C(1) << 31 && columns <= UINT64_C(1) << 31);
    // a mostly empty grid gives no neighbours and would waste memory
    if (rows * columns <= 8 * scan->record_count + 65536) {
        scan->rows = rows;
        scan->columns = columns;
    }
}

static stp_result fail_scan(const stp_e57* e57, uint32_t number, const char* what)
{
    return stp_fail(e57->import->context, STP_ERROR_FORMAT, "%s: scan %u: %s", e57->import->path,
                    number, what);
}

stp_result stp_e57_describe_scan(stp_e57* e57, const stp_e57_node* node, uint32_t number,
                                 stp_e57_scan* scan)
{
    *scan = (stp_e57_scan){0};
    const stp_e57_node* name = stp_e57_child(node, "name");
    const stp_e57_node* points = stp_e57_child(node, "points");
    const stp_e57_node* prototype = stp_e57_child(points, "prototype");
    if (name != NULL && name->text.length > 0) {
        scan->name = stp_arena_copy_text(&e57->arena, name->text.bytes, name->text.length);
        if (scan->name == NULL) {
            return stp_fail_memory(e57->import->context);
        }
    }
    if (points == NULL || prototype == NULL) {
        return STP_OK;
    }
    uint64_t section = 0;
    if (!stp_e57_unsigned(stp_e57_attribute_of(points, "fileOffset"), &section) ||
        !stp_e57_unsigned(stp_e57_attribute_of(points, "recordCount"), &scan->record_count)) {
        return fail_scan(e57, number, "its points have no fileOffset or no recordCount");
    }
    scan->section = stp_e57_logical(e57, section);
    scan->spherical = stp_e57_child(prototype, "cartesianX") == NULL;
    if (!read_prototype(prototype, scan)) {
        return fail_scan(e57, number,
                         "a field of its records has an unknown type or invalid bounds");
    }
    if (!read_pose(stp_e57_child(node, "pose"), &scan->pose)) {
        return fail_scan(e57, number, "its pose is not a rotation and a translation");
    }
    stp_e57_field* f = scan->fields;
    scan->has_places = f[STP_E57_X].used && f[STP_E57_Y].used && f[STP_E57_Z].used;
    read_limits(node, "intensityLimits", "intensityMinimum", "intensityMaximum",
                &f[STP_E57_INTENSITY]);
    read_limits(node, "colorLimits", "colorRedMinimum", "colorRedMaximum", &f[STP_E57_RED]);
    read_limits(node, "colorLimits", "colorGreenMinimum", "colorGreenMaximum", &f[STP_E57_GREEN]);
    read_limits(node, "colorLimits", "colorBlueMinimum", "colorBlueMaximum", &f[STP_E57_BLUE]);
    find_grid(scan);
    return STP_OK;
}
