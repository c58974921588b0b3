# The targets Rhytid::rhytid, the shared library, and Rhytid::static. Each is there if its file is.
get_filename_component(_rhytid_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

find_library(Rhytid_SHARED NAMES rhytid_c PATHS "${_rhytid_prefix}/lib" NO_DEFAULT_PATH NO_CACHE)
set(_rhytid_static "${_rhytid_prefix}/lib/${CMAKE_STATIC_LIBRARY_PREFIX}rhytid_c${CMAKE_STATIC_LIBRARY_SUFFIX}")

if(Rhytid_SHARED AND NOT Rhytid_SHARED STREQUAL _rhytid_static AND NOT TARGET Rhytid::rhytid)
  # Without IMPORTED_NO_SONAME, programs would remember the library by its whole path.
  add_library(Rhytid::rhytid SHARED IMPORTED)
  set_target_properties(Rhytid::rhytid PROPERTIES
    IMPORTED_LOCATION "${Rhytid_SHARED}"
    IMPORTED_IMPLIB "${Rhytid_SHARED}"
    IMPORTED_NO_SONAME TRUE
    INTERFACE_INCLUDE_DIRECTORIES "${_rhytid_prefix}/include")
endif()

if(EXISTS "${_rhytid_static}" AND NOT TARGET Rhytid::static)
  add_library(Rhytid::static STATIC IMPORTED)
  set_target_properties(Rhytid::static PROPERTIES
    IMPORTED_LOCATION "${_rhytid_static}"
    INTERFACE_INCLUDE_DIRECTORIES "${_rhytid_prefix}/include"
    INTERFACE_LINK_LIBRARIES "@SYSTEM@")
endif()

set(Rhytid_FOUND FALSE)
if(TARGET Rhytid::rhytid OR TARGET Rhytid::static)
  set(Rhytid_FOUND TRUE)
endif()
