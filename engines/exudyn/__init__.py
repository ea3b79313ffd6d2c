"""The mechanism in Exudyn: ANCF cable elements on which the slider rides through a moving ALE joint."""
