/* What the device implements: subtypes, parameters, extensions. */
#ifndef CVOL_ANARI_QUERIES_H
#define CVOL_ANARI_QUERIES_H

#include <anari/anari.h>

#include <string>

namespace cvol_anari
{

/* The extensions, ended by NULL. */
const char **extensions();
/* The subtypes of a type, ended by NULL. */
const char **subtypes(ANARIDataType type);
/* "" if the parameter has this type, or is unknown; else a sentence. */
std::string check_parameter(ANARIDataType type, const char *subtype, const char *name,
                            ANARIDataType given);
/* See anariGetObjectInfo and anariGetParameterInfo; NULL: there is no such fact. */
const void *object_info(ANARIDataType type, const char *subtype, const char *info,
                        ANARIDataType info_type);
const void *parameter_info(ANARIDataType type, const char *subtype, const char *name,
                           ANARIDataType parameter_type, const char *info, ANARIDataType info_type);

} // namespace cvol_anari
#endif
