"""Small IFC models, authored for tests."""

import ifcopenshell
import ifcopenshell.guid
import numpy as np


class Author:
    """A model with one building; lengths are given in m and written in ``unit``, m."""

    def __init__(self, schema="IFC4", unit=1.0, turned=0.0, at=(0.0, 0.0, 0.0)):
        self.model = ifcopenshell.file(schema=schema)
        self.unit = unit or 1.0  # 0: no unit is written
        self.turned = turned
        self.history = None
        if schema == "IFC2X3":
            self.history = self._history()
        axis = self._axes((0.0, 0.0, 0.0))
        context = self.model.createIfcGeometricRepresentationContext(
            ContextIdentifier="Body", ContextType="Model", CoordinateSpaceDimension=3,
            Precision=1e-5, WorldCoordinateSystem=axis,
        )  # fmt: skip
        self.context = context
        units = []
        if unit:
            prefix = {1.0: None, 0.001: "MILLI"}.get(unit)
            length = self.model.createIfcSIUnit(None, "LENGTHUNIT", prefix, "METRE")
            if unit not in {1.0, 0.001}:  # feet
                dimensions = self.model.createIfcDimensionalExponents(1, 0, 0, 0, 0, 0, 0)
                measure = self.model.createIfcMeasureWithUnit(
                    self.model.create_entity("IfcLengthMeasure", unit), length
                )
                length = self.model.createIfcConversionBasedUnit(
                    dimensions, "LENGTHUNIT", "FOOT", measure
                )
            units.append(length)
        assigned = self.model.createIfcUnitAssignment(
            units or [self.model.createIfcSIUnit(None, "AREAUNIT", None, "SQUARE_METRE")]
        )
        self.project = self.root(
            "IfcProject", RepresentationContexts=[context], UnitsInContext=assigned
        )
        self.building = self.root(
            "IfcBuilding", ObjectPlacement=self.placement(at, turned), CompositionType="ELEMENT"
        )
        self._aggregate(self.project, [self.building])
        self.storeys = []

    def storey(self, name, height=0.0, elevation=None):
        storey = self.root(
            "IfcBuildingStorey", Name=name, CompositionType="ELEMENT",
            Elevation=(height if elevation is None else elevation) / self.unit,
            ObjectPlacement=self.placement((0.0, 0.0, height), 0.0, self.building.ObjectPlacement),
        )  # fmt: skip
        self._aggregate(self.building, [storey])
        self.storeys.append(storey)
        return storey

    def box(self, kind, low, high, *, storey=None, turned=0.0, **attributes):
        """Product whose body is a box from ``low`` to ``high`` in the storey's frame, m."""
        low, high = np.array(low, dtype=float), np.array(high, dtype=float)
        storey = storey or self.storeys[-1]
        place = self.placement(low, turned, storey.ObjectPlacement)
        product = self.root(
            kind, ObjectPlacement=place, Representation=self._box(high - low), **attributes
        )
        if kind == "IfcSpace":
            self._aggregate(storey, [product])
        elif kind != "IfcOpeningElement":
            self.root(
                "IfcRelContainedInSpatialStructure", RelatedElements=[product],
                RelatingStructure=storey,
            )  # fmt: skip
        return product

    def opening(self, wall, low, high, **options):
        opening = self.box("IfcOpeningElement", low, high, **options)
        self.root("IfcRelVoidsElement", RelatingBuildingElement=wall, RelatedOpeningElement=opening)
        return opening

    def door(self, wall, low, high, *, lining=0.0, along=0, **options):
        """A door in an opening from ``low`` to ``high``; ``along``: axis of the wall."""
        opening = self.opening(wall, low, high)
        width = high[along] - low[along]
        door = self.box(
            "IfcDoor", low, high, OverallWidth=width / self.unit,
            OverallHeight=(high[2] - low[2]) / self.unit, **options,
        )  # fmt: skip
        self.root("IfcRelFillsElement", RelatingOpeningElement=opening, RelatedBuildingElement=door)
        if lining:
            shape = self.root("IfcDoorLiningProperties", LiningThickness=lining / self.unit)
            self.root(
                "IfcRelDefinesByProperties", RelatedObjects=[door], RelatingPropertyDefinition=shape
            )
        return door

    def write(self, file):
        self.model.write(str(file))
        return file

    def root(self, kind, **attributes):
        return self.model.create_entity(
            kind, GlobalId=ifcopenshell.guid.new(), OwnerHistory=self.history, **attributes
        )

    def placement(self, at, turned=0.0, relative=None):
        return self.model.createIfcLocalPlacement(relative, self._axes(at, turned))

    def _axes(self, at, turned=0.0):
        point = self.model.createIfcCartesianPoint([float(v) / self.unit for v in at])
        x = self.model.createIfcDirection([float(np.cos(turned)), float(np.sin(turned)), 0.0])
        z = self.model.createIfcDirection([0.0, 0.0, 1.0])
        return self.model.createIfcAxis2Placement3D(point, z, x)

    def _box(self, size):
        dx, dy, dz = (float(v) / self.unit for v in size)
        corners = [(0.0, 0.0), (dx, 0.0), (dx, dy), (0.0, dy), (0.0, 0.0)]
        line = self.model.createIfcPolyline(
            [self.model.createIfcCartesianPoint(corner) for corner in corners]
        )
        profile = self.model.createIfcArbitraryClosedProfileDef("AREA", None, line)
        solid = self.model.createIfcExtrudedAreaSolid(
            profile, self._axes((0.0, 0.0, 0.0)), self.model.createIfcDirection([0.0, 0.0, 1.0]), dz
        )
        body = self.model.createIfcShapeRepresentation(self.context, "Body", "SweptSolid", [solid])
        return self.model.createIfcProductDefinitionShape(None, None, [body])

    def _aggregate(self, whole, parts):
        self.root("IfcRelAggregates", RelatingObject=whole, RelatedObjects=parts)

    def _history(self):
        person = self.model.createIfcPerson(FamilyName="Test")
        firm = self.model.createIfcOrganization(Name="Test")
        owner = self.model.createIfcPersonAndOrganization(person, firm)
        program = self.model.createIfcApplication(firm, "1", "Test", "test")
        return self.model.createIfcOwnerHistory(owner, program, None, "ADDED", None, None, None, 0)


def two_rooms(*, spaces=True, slab=True, door=0.9, lining=0.0, **options):
    """Two rooms of 4 × 3 m and 3 × 3 m beside each other, walls of 0.2 m, a door in between.

    The first one has a front door of 1 m in its south wall.
    """
    author = Author(**options)
    storey = author.storey("Ground Floor")
    wide = 7.6
    if slab:
        author.box("IfcSlab", (0, 0, -0.2), (wide, 3.4, 0.0))
    walls = {
        "south": ((0, 0, 0), (wide, 0.2, 2.5)),
        "north": ((0, 3.2, 0), (wide, 3.4, 2.5)),
        "west": ((0, 0.2, 0), (0.2, 3.2, 2.5)),
        "east": ((wide - 0.2, 0.2, 0), (wide, 3.2, 2.5)),
        "middle": ((4.2, 0.2, 0), (4.4, 3.2, 2.5)),
    }
    made = {name: author.box("IfcWall", *ends, Name=name) for name, ends in walls.items()}
    author.door(
        made["middle"], (4.2, 1.0, 0), (4.4, 1.0 + door, 2.1), lining=lining, along=1, Name="D1"
    )
    author.door(made["south"], (1.0, 0, 0), (2.0, 0.2, 2.1), Name="D0")
    if spaces:
        author.box("IfcSpace", (0.2, 0.2, 0), (4.2, 3.2, 2.5), Name="101", LongName="Office")
        author.box("IfcSpace", (4.4, 0.2, 0), (7.4, 3.2, 2.5), Name="102", LongName="Ward 3")
    return author, storey
