// SPDX-License-Identifier: MIT
// Attributes of scanned points, under the names that PDAL, CloudCompare and others give the
// properties of PLY files.
#include "import/ply/ply.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

static const char* const names[STP_ATTRIBUTES] = {
    [STP_ATTRIBUTE_INTENSITY] = "intensity Intensity scalar_Intensity scalar_intensity",
    [STP_ATTRIBUTE_CLASS] = "classification class Classification scalar_Classification "
                            "scalar_classification label",
    [STP_ATTRIBUTE_RETURN] = "return_number return returnnumber ReturnNumber scalar_ReturnNumber "
                             "scalar_Return_Number scalar_return_number",
    [STP_ATTRIBUTE_RETURNS] = "number_of_returns returns numberofreturns NumberOfReturns "
                              "scalar_NumberOfReturns scalar_Number_Of_Returns "
                              "scalar_number_of_returns",
    [STP_ATTRIBUTE_SCAN_ANGLE] = "scan_angle scan_angle_rank scananglerank ScanAngleRank "
                                 "scalar_ScanAngleRank scalar_Scan_Angle_Rank scalar_ScanAngle",
    [STP_ATTRIBUTE_SOURCE] = "point_source_id source pointsourceid PointSourceId "
                             "scalar_PointSourceId scalar_Point_Source_ID scalar_PointSourceID",
    [STP_ATTRIBUTE_TIME] = "gps_time time gpstime GpsTime scalar_GpsTime scalar_Gps_Time "
                           "scalar_gps_time",
    [STP_ATTRIBUTE_NEAR_INFRARED] = "near_infrared nir infrared Infrared scalar_Infrared "
                                    "scalar_Nir scalar_NIR",
};

static bool is_strength(int attribute)
{
    return attribute == STP_ATTRIBUTE_INTENSITY || attribute == STP_ATTRIBUTE_NEAR_INFRARED;
}

void stp_ply_find_attributes(const stp_ply_element* element, stp_ply_attributes* a)
{
    for (size_t i = 0; i < element->property_count; ++i) {
        const stp_ply_property* property = &element->properties[i];
        for (int k = 0; k < STP_ATTRIBUTES && !property->is_list; ++k) {
            if (a->properties[k] == NULL && stp_ply_is_one_of(property->name, names[k])) {
                a->properties[k] = property;
                a->scaled_later[k] = is_strength(k) && (property->type == STP_PLY_FLOAT32 ||
                                                        property->type == STP_PLY_FLOAT64);
                atomic_init(&a->strong[k], false);
            }
        }
    }
}

stp_result stp_ply_alloc_attributes(const stp_ply* ply, const stp_ply_room* room, size_t count,
                                    stp_ply_attributes* a)
{
    stp_bulk_array arrays[STP_ATTRIBUTES] = {{0}};
    for (int k = 0; k < STP_ATTRIBUTES; ++k) {
        size_t size = a->scaled_later[k] ? sizeof(float) : stp_attribute_size((stp_attribute)k);
        arrays[k].size = a->properties[k] != NULL ? size * count : 0;
    }
    stp_result result =
        room->spilled ? stp_bulk_alloc_spilled(ply->import->scene->spill, arrays, STP_ATTRIBUTES)
                      : STP_OK;
    for (int k = 0; k < STP_ATTRIBUTES && result == STP_OK; ++k) {
        if (!room->spilled && arrays[k].size != 0) {
            arrays[k].bytes = stp_alloc(ply->context, arrays[k].size);
            result = arrays[k].bytes != NULL ? STP_OK : stp_fail_memory(ply->context);
        }
        a->columns[k] = arrays[k].size != 0 ? arrays[k].bytes : NULL;
    }
    return result;
}

// The nearest whole number within bounds; NaN gives the lower bound.
static double whole_within(double value, double low, double high)
{
    assert(low <= high);
    return value > low ? (value < high ? floor(value + 0.5) : high) : low;
}

static double scale_of(const stp_ply_property* property, int attribute)
{
    if (attribute == STP_ATTRIBUTE_SCAN_ANGLE) {
        return 1.0 / 0.006; // files hold degrees
    }
    return is_strength(attribute) && property->type == STP_PLY_UINT8 ? 257.0 : 1.0;
}

void stp_ply_store_attribute(stp_ply_attributes* a, int attribute, size_t row, double value)
{
    assert(attribute >= 0 && attribute < STP_ATTRIBUTES);
    void* column = a->columns[attribute];
    if (column == NULL) {
        return;
    }
    if (a->scaled_later[attribute]) {
        ((float*)column)[row] = (float)value;
        if (value > 1.0 && value <= DBL_MAX) {
            atomic_store_explicit(&a->strong[attribute], true, memory_order_relaxed);
        }
        return;
    }
    if (attribute == STP_ATTRIBUTE_TIME) {
        ((double*)column)[row] = value;
        return;
    }
    value *= scale_of(a->properties[attribute], attribute);
    if (attribute == STP_ATTRIBUTE_SCAN_ANGLE) {
        ((int16_t*)column)[row] = (int16_t)whole_within(value, -30000.0, 30000.0);
    } else if (stp_attribute_size((stp_attribute)attribute) == 1) {
        ((uint8_t*)column)[row] = (uint8_t)whole_within(value, 0.0, 255.0);
    } else {
        ((uint16_t*)column)[row] = (uint16_t)whole_within(value, 0.0, 65535.0);
    }
}

void stp_ply_move_attributes(stp_ply_attributes* a, size_t from, size_t to)
{
    assert(to <= from);
    for (int k = 0; k < STP_ATTRIBUTES; ++k) {
        size_t size = a->scaled_later[k] ? sizeof(float) : stp_attribute_size((stp_attribute)k);
        unsigned char* column = a->columns[k];
        if (column != NULL) {
            memcpy(column + to * size, column + from * size, size);
        }
    }
}

// Converts floats from 0 to 1, or from 0 to 65535, to whole numbers, in place.
static void scale_column(stp_ply_attributes* a, int attribute, size_t count)
{
    unsigned char* column = a->columns[attribute];
    assert(stp_attribute_size((stp_attribute)attribute) <= sizeof(float) && "scaled in place");
    double scale = atomic_load(&a->strong[attribute]) ? 1.0 : 65535.0;
    for (size_t i = 0; i < count; ++i) {
        float value;
        memcpy(&value, column + i * sizeof(value), sizeof(value));
        uint16_t number = (uint16_t)whole_within((double)value * scale, 0.0, 65535.0);
        memcpy(column + i * sizeof(number), &number, sizeof(number));
    }
}

void stp_ply_hand_attributes(stp_ply_attributes* a, size_t count, void* columns[STP_ATTRIBUTES])
{
    for (int k = 0; k < STP_ATTRIBUTES; ++k) {
        if (a->columns[k] != NULL && a->scaled_later[k]) {
            scale_column(a, k, count);
        }
        columns[k] = a->columns[k];
        a->columns[k] = NULL;
    }
}
