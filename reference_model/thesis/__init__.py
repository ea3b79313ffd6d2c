"""The model as the thesis published it: deflection W in cubic elements, second-order foreshortening, pseudo-coordinate at the coupler.

With more elements and exact geometry it is a witness of the converged model in other coordinates.
"""
