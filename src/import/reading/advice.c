// SPDX-License-Identifier: MIT
#include "import/reading/advice.h"

#include <string.h>
#include <strings.h>

typedef struct advice {
    const char* extensions; ///< separated by spaces
    const char* name;
    const char* what; ///< "export ..."
} advice;

#define FROM_CAD "export glTF, OBJ or STL from the CAD program"

static const advice advices[] = {
    {"wrl vrml wrz x3dv", "VRML", "convert it to glTF or X3D, for example with MeshLab or FreeCAD"},
    {"jt", "JT", FROM_CAD ", or convert it, for example with CAD Exchanger"},
    {"mpd ldr ldraw", "LDraw", "export OBJ or COLLADA, for example with LeoCAD"},
    {"dwg", "DWG", "export DXF or FBX, or convert it, for example with FreeCAD"},
    {"rvt rfa", "Revit", "export IFC from Revit"},
    {"nwd nwc", "Navisworks", "export FBX from Navisworks"},
    {"skp", "SketchUp", "export glTF or COLLADA from SketchUp"},
    {"3dm", "Rhino", "export glTF or OBJ from Rhino"},
    {"usd usda usdc usdz", "USD", "convert it to glTF, for example with Blender"},
    {"max c4d ma mb hip", "a scene of a modelling program", "export FBX or glTF from that program"},
    {"sldprt sldasm ipt iam catpart catproduct prt asm x_t x_b sat brep f3d",
     "a file of a CAD program", FROM_CAD},
    {"rcp rcs fls zfs dp ptg", "a scan in the format of its program",
     "export E57 or LAZ from that program"},
    {"zip gz 7z tar rar bz2 xz", "an archive", "unpack it first"},
};

static bool names(const char* extensions, const char* extension)
{
    size_t length = strlen(extension);
    for (const char* at = extensions; *at != '\0';) {
        size_t word = strcspn(at, " ");
        if (word == length && strncasecmp(at, extension, length) == 0) {
            return true;
        }
        at += word + (at[word] == ' ');
    }
    return false;
}

stp_result stp_import_refuse_unknown(stp_import* import)
{
    const char* slash = strrchr(import->path, '/');
    const char* dot = strrchr(slash != NULL ? slash : import->path, '.');
    for (size_t i = 0; dot != NULL && i < sizeof(advices) / sizeof(advices[0]); ++i) {
        if (names(advices[i].extensions, dot + 1)) {
            return stp_fail(import->context, STP_ERROR_UNSUPPORTED,
                            "%s: is %s, which is not supported: %s", import->path, advices[i].name,
                            advices[i].what);
        }
    }
    return stp_fail(import->context, STP_ERROR_UNSUPPORTED,
                    "%s: unknown format: neither its content nor its extension is supported",
                    import->path);
}
